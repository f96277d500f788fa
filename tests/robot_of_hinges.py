"""A humanoid robot of hinges, its root with x forward, y to the left and z up, in the proportions of nobody."""

import numpy as np
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, forward_kinematics
from skpose.datasets import humanoid

LEG = (("pelvis", "thigh"), ("thigh", "shank"))
LIMITS = {
    "hip_1": (-2.2, 1.2),
    "hip_2": (-0.6, 0.6),
    "hip_3": (-0.8, 0.8),
    "knee": (0.0, 2.4),
    "ankle_1": (-0.9, 0.6),
    "ankle_2": (-0.3, 0.3),
    "shoulder_1": (-3.0, 2.0),
    "shoulder_2": (-1.8, 1.8),
    "shoulder_3": (-1.6, 1.6),
    "elbow": (-2.4, 0.0),
    "waist_1": (-1.5, 1.5),
    "waist_2": (-0.4, 0.6),
    "head": (-0.5, 0.5),
}


def robot(*, legs=True, arms=True, size=1.0, tilt=0.0, seed=None, thigh=0.3, shank=0.3):
    """Return the robot.

    Hips and shoulders have first axes tilted by `tilt`, rad, as some robots'. With a seed links have axes turned at
    random, which changes no movement.
    """
    rng = np.random.default_rng(seed)
    oriented, where, bones = {None: Rotation.identity()}, {None: np.zeros(3)}, []

    def add(name, parent, position, axis=None, fixed=False):
        turn = Rotation.identity() if seed is None else Rotation.random(random_state=rng)
        oriented[name], where[name] = turn, size * np.array(position)
        offset = oriented[parent].inv().apply(where[name] - where[parent])
        bone = Bone(name, parent, offset, rest_rotation=(oriented[parent].inv() * turn).as_matrix())
        if axis is not None:
            kind = name.removeprefix("left_").removeprefix("right_")
            axis = turn.inv().apply(axis)
            bone = bone._replace(dofs="hinge", axis=axis, dof_name=f"{name}_joint", limits=[LIMITS[kind]])
        bones.append(bone)

    x, y, z = np.eye(3)
    if arms:
        add("waist_1", None, (0, 0, 0.05), z)
        add("waist_2", "waist_1", (0, 0, 0.05), y)
        add("head", "waist_2", (0, 0, 0.45), z)
        add("camera", "head", (0.05, 0, 0.5))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        leaning = Rotation.from_rotvec(sign * tilt * x)
        if arms:
            arm = [(0, sign * 0.15, 0.35), (0, sign * 0.15, 0.15), (0, sign * 0.15, -0.05)]
            add(f"{side}_shoulder_1", "waist_2", arm[0], leaning.apply(y))
            add(f"{side}_shoulder_2", f"{side}_shoulder_1", arm[0], x)
            add(f"{side}_shoulder_3", f"{side}_shoulder_2", arm[0], z)
            add(f"{side}_elbow", f"{side}_shoulder_3", arm[1], y)
            add(f"{side}_hand", f"{side}_elbow", arm[2])
        if not legs:
            continue
        leg = [(0, sign * 0.1, -0.1), (0, sign * 0.1, -0.1 - thigh), (0, sign * 0.1, -0.1 - thigh - shank)]
        add(f"{side}_hip_1", None, leg[0], leaning.apply(y))
        add(f"{side}_hip_2", f"{side}_hip_1", leg[0], x)
        add(f"{side}_hip_3", f"{side}_hip_2", leg[0], z)
        add(f"{side}_knee", f"{side}_hip_3", leg[1], y)
        add(f"{side}_ankle_1", f"{side}_knee", leg[2], y)
        add(f"{side}_ankle_2", f"{side}_ankle_1", leg[2], x)
        add(f"{side}_toe", f"{side}_ankle_2", np.add(leg[2], (0.12, 0, -0.05)))
    return Skeleton(bones, "parent")


def counterparts(skeleton):
    """Return the joints of `skpose.datasets.humanoid` that the robot's links are."""
    names = {"hip_1": "pelvis", "knee": "thigh", "ankle_1": "shank", "toe": "foot"}
    names |= {"shoulder_1": "clavicle", "elbow": "upper_arm", "hand": "forearm"}
    pairs = {f"{side}_{link}": f"{side}_{bone}" for side in ("left", "right") for link, bone in names.items()}
    return {link: bone for link, bone in pairs.items() if link in skeleton}


def walk(n_steps=4, step=0.4, stance=0.6, frame_rate=60.0):
    """Return a walk of the humanoid along z, y up, on a floor at zero, and in which frames (2, n) each foot stands.

    Its feet are flat, and still while they stand, as those of no recording are.
    """
    person = humanoid()
    names = {name: i for i, name in enumerate(person.dof_names)}
    zero = dict(zip(person.joint_names, forward_kinematics(np.zeros((1, person.n_dofs)), person)[0], strict=True))
    thigh, shank = (np.linalg.norm(zero[f"left_{end}"] - zero[f"left_{start}"]) for start, end in LEG)
    times = np.arange(round(n_steps * stance * frame_rate)) / frame_rate
    height = 0.92 * (thigh + shank) + 0.08 + 0.01 * np.cos(2.0 * np.pi * times / stance)
    root = np.stack([0.0 * times, height, step / stance * times], axis=1)
    angles, stands = np.zeros((len(times), person.n_dofs)), np.zeros((2, len(times)), bool)
    for k, side in enumerate(("left", "right")):
        done, share = np.divmod(times / (2.0 * stance) + 0.5 * k, 1.0)  # a cycle is two steps
        stands[k] = share < 0.6
        swing = np.clip((share - 0.6) / 0.4, 0.0, 1.0)
        ahead = 2.0 * step * (done + swing * swing * (3.0 - 2.0 * swing) - 0.5 * k) + 0.6 * step - root[:, 2]
        below = height - 0.08 - 0.1 * np.sin(np.pi * swing) ** 2
        reach = np.hypot(ahead, below)
        at_hip = np.arccos((thigh**2 + reach**2 - shank**2) / (2.0 * thigh * reach))
        knee = np.pi - np.arccos((thigh**2 + shank**2 - reach**2) / (2.0 * thigh * shank))
        lift = np.arctan2(ahead, below) + at_hip  # of the thigh, forward
        for bone, angle in (("thigh", -lift), ("shank", knee), ("foot", lift - knee)):
            angles[:, names[f"{side}_{bone}_rx"]] = angle
    return Motion(person, angles, frame_rate, root), stands
