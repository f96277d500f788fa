"""One performance of an action: the motion of a person between key poses, and the person's departures from them.

Key poses state where the pelvis and the feet are; feet and the height of the pelvis depart with the joints of the legs,
and the legs follow in closed form. Between key poses everything moves along monotone cubic curves (PCHIP). Legs that
stand are solved for every frame, so their feet do not slide.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation

from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rotations import continuous_columns

# --- key poses --------------------------------------------------------------------------------------------------------
# Of ten actions, of our own: what a person does with trunk, arms and feet, and when.
#
# Angles in degrees. Lengths are in lengths of the leg, from hip to ankle, so that people of any size do the same.
# Everybody uses the right hand, steps and swings with the right foot first, and turns to the left.


class Arm(NamedTuple):
    """One arm."""

    raised: float = 8.0  # of the upper arm, from hanging
    plane: float = 75.0  # in which it is raised: 0 in front, 90 at the side, 180 behind
    inward: float = 0.0  # rotation of the upper arm about itself, which a bent forearm follows
    elbow: float = 15.0  # flexion


class Foot(NamedTuple):
    """One foot: the position of its ankle if the foot is flat, relative to standing at the beginning."""

    forward: float = 0.0
    up: float = 0.0
    left: float = 0.0
    heel: float = 0.0  # by which the foot is rotated about its ball, heel up; negative: toes up
    outward: float = 7.0  # rotation about the vertical
    stands: bool = True  # on its ball at least


class Key(NamedTuple):
    """A key pose; the pelvis relative to standing with straight legs at the beginning."""

    time: float  # share of the duration
    down: float = 0.004
    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0  # of the pelvis, to the left
    tilt: float = 0.0  # forward
    lean: float = 0.0  # of the trunk on the pelvis, forward
    twist: float = 0.0  # to the left
    bend: float = 0.0  # to the right
    nod: float = 0.0  # of neck and head on the trunk, forward
    right_arm: Arm = Arm()
    left_arm: Arm = Arm()
    right_foot: Foot = Foot()
    left_foot: Foot = Foot()
    sits: bool = False  # the seat gives the height of the pelvis


class Action(NamedTuple):
    """An action."""

    duration: float  # s
    keys: tuple[Key, ...]


def arms(arm: Arm) -> dict[str, Any]:
    """Both arms of a key pose, mirrored."""
    return {"right_arm": arm, "left_arm": arm}


def feet(foot: Foot) -> dict[str, Any]:
    """Both feet."""
    return {"right_foot": foot, "left_foot": foot}


GUARD, BALANCE = Arm(35, 40, 20, 60), Arm(35, 150, 0, 30)
HOLDING, OVER_HEAD, WAVE = Arm(18, 5, 15, 80), Arm(150, 12, 0, 20), Arm(72, 70, -80)
STEP, HIGH = 0.42, 0.26  # of the step: distance and height
ON_STEP = Foot(STEP, HIGH)
# Of someone who turns by half a turn around the middle between the feet: the left first, then the right.
HALF_LEFT, HALF_RIGHT = Foot(-0.19, 0, -0.14, 0, 82), Foot(0, 0, 0.389, 0, -173)

ACTIONS: Mapping[str, Action] = {
    "jump": Action(
        1.6,
        (
            Key(0),
            Key(0.27, down=0.3, forward=-0.1, tilt=25, lean=25, nod=-20, **arms(Arm(35, 165))),
            Key(0.47, down=-0.09, forward=0.04, lean=-5, **arms(Arm(80, 10)), **feet(Foot(heel=45))),
            Key(
                0.61, down=-0.3, forward=0.06, **arms(Arm(140, 15)),
                **feet(Foot(forward=0.05, up=0.28, heel=35, stands=False)),
            ),
            Key(
                0.75, down=-0.02, forward=0.05, tilt=5, lean=10, **arms(Arm(75, 25)),
                **feet(Foot(forward=0.08, heel=20)),
            ),
            Key(
                0.85, down=0.24, forward=-0.02, tilt=20, lean=20, nod=-15, **arms(Arm(40, 30)),
                **feet(Foot(forward=0.08)),
            ),
            Key(1, forward=0.08, **feet(Foot(forward=0.08))),
        ),
    ),
    "kick": Action(
        1.8,
        (
            Key(0),
            Key(
                0.28, down=0.03, left=0.1, turn=-5, tilt=-2, lean=5, right_arm=BALANCE, left_arm=GUARD,
                right_foot=Foot(forward=0.22, up=0.42, left=0.03, heel=20, stands=False),
            ),
            Key(
                0.43, down=0.02, forward=0.04, left=0.1, turn=10, tilt=-15, lean=10, twist=-10, nod=5,
                right_arm=BALANCE, left_arm=Arm(60, 20, 20, 45),
                right_foot=Foot(forward=0.97, up=0.75, left=0.06, heel=-55, stands=False),
            ),
            Key(
                0.6, down=0.03, left=0.1, turn=-5, tilt=-2, lean=5, right_arm=BALANCE, left_arm=GUARD,
                right_foot=Foot(forward=0.24, up=0.4, left=0.03, heel=15, stands=False),
            ),
            Key(0.8, down=0.02, left=0.03, **arms(Arm(15, 60, 0, 25))),
            Key(1),
        ),
    ),
    "lift": Action(
        2.8,
        (
            Key(0),
            Key(0.36, down=0.38, forward=-0.2, tilt=38, lean=20, nod=-20, **arms(Arm(75, -6, 0, 8))),
            Key(0.46, down=0.38, forward=-0.2, tilt=38, lean=20, nod=-15, **arms(Arm(75, -10, 0, 8))),
            Key(0.64, down=0.2, forward=-0.15, tilt=30, lean=15, nod=-10, **arms(Arm(50, -6, 10, 30))),
            Key(0.84, forward=-0.02, lean=-5, **arms(HOLDING)),
            Key(1, lean=-5, **arms(HOLDING)),
        ),
    ),
    "reach": Action(
        2.1,
        (
            Key(0),
            Key(0.25, forward=0.01, nod=-8, right_arm=Arm(70, 10, 0, 45)),
            Key(
                0.47, down=-0.05, forward=0.08, left=-0.02, turn=8, lean=-4, twist=8, bend=-8, nod=-20,
                right_arm=OVER_HEAD, **feet(Foot(heel=18)),
            ),
            Key(
                0.58, down=-0.05, forward=0.08, left=-0.02, turn=8, lean=-4, twist=8, bend=-8, nod=-20,
                right_arm=OVER_HEAD, **feet(Foot(heel=18)),
            ),
            Key(0.8, forward=0.01, right_arm=Arm(60, 15, 10, 60)),
            Key(1),
        ),
    ),
    "sit down": Action(
        2.2,
        (
            Key(0),
            Key(0.35, down=0.12, forward=-0.18, tilt=25, lean=20, nod=-10, **arms(Arm(30, 20))),
            Key(0.7, down=0.46, forward=-0.43, tilt=20, lean=22, nod=-15, sits=True, **arms(Arm(40, 5, 0, 30))),
            Key(0.86, down=0.46, forward=-0.45, tilt=-4, lean=6, sits=True, **arms(Arm(24, 5, 10, 48))),
            Key(1, down=0.46, forward=-0.45, tilt=-6, lean=6, sits=True, **arms(Arm(20, 5, 10, 50))),
        ),
    ),
    "squat": Action(
        1.6,
        (
            Key(0),
            Key(0.25, down=0.2, forward=-0.12, tilt=18, lean=12, nod=-8, **arms(Arm(62, 8))),
            Key(0.5, down=0.44, forward=-0.19, tilt=25, lean=22, nod=-20, **arms(Arm(112, 8))),
            Key(0.75, down=0.2, forward=-0.12, tilt=18, lean=12, nod=-8, **arms(Arm(62, 8))),
            Key(1),
        ),
    ),
    "step up": Action(
        2.2,
        (
            Key(0),
            Key(
                0.22, down=0.02, forward=0.04, left=0.1, tilt=3, lean=6, right_arm=Arm(12, 150, 0, 20),
                left_arm=Arm(22, 10, 0, 30), right_foot=Foot(forward=0.22, up=0.36, heel=10, stands=False),
            ),
            Key(
                0.4, down=0.04, forward=0.14, left=0.04, tilt=6, lean=10, right_arm=Arm(15, 150, 0, 20),
                left_arm=Arm(25, 10, 0, 30), right_foot=ON_STEP, left_foot=Foot(heel=12),
            ),
            Key(
                0.66, down=-0.18, forward=0.38, left=-0.08, tilt=8, lean=8, right_arm=Arm(25, 10, 0, 30),
                left_arm=Arm(15, 150, 0, 20), right_foot=ON_STEP,
                left_foot=Foot(forward=0.12, up=0.2, heel=45, stands=False),
            ),
            Key(
                0.82, down=-0.24, forward=0.42, left=-0.06, lean=3, right_arm=Arm(15, 40), left_arm=Arm(12, 100),
                right_foot=ON_STEP, left_foot=Foot(forward=0.4, up=0.42, heel=10, stands=False),
            ),
            Key(1, down=0.004 - HIGH, forward=STEP, **feet(ON_STEP)),
        ),
    ),
    "throw": Action(
        2,
        (
            Key(0),
            Key(
                0.32, down=0.04, forward=-0.03, left=-0.1, turn=-30, tilt=-3, lean=-4, twist=-30, bend=5,
                right_arm=Arm(88, 105, -75, 95), left_arm=Arm(70, 15, 20, 25),
                left_foot=Foot(forward=0.15, up=0.14, heel=15, stands=False),
            ),
            Key(
                0.47, down=0.06, forward=0.18, left=-0.02, turn=-15, twist=-25, right_arm=Arm(95, 100, -90, 95),
                left_arm=Arm(75, 25, 20, 20), right_foot=Foot(outward=35), left_foot=Foot(forward=0.45),
            ),
            Key(
                0.57, down=0.07, forward=0.28, left=0.02, turn=15, tilt=5, lean=10, twist=15, bend=-8,
                right_arm=Arm(135, 35, -20, 25), left_arm=Arm(40, 60, 0, 45), right_foot=Foot(heel=28, outward=35),
                left_foot=Foot(forward=0.45),
            ),
            Key(
                0.68, down=0.09, forward=0.34, left=0.04, turn=25, tilt=12, lean=25, twist=28, bend=5,
                right_arm=Arm(55, -25, 30, 20), left_arm=Arm(30, 120, 0, 40), right_foot=Foot(heel=42, outward=35),
                left_foot=Foot(forward=0.45),
            ),
            Key(
                0.84, down=0.04, forward=0.42, left=0.02, turn=5, tilt=3, lean=8, twist=8,
                right_arm=Arm(20, 20, 10, 25), left_arm=Arm(15, 75, 0, 25),
                right_foot=Foot(forward=0.25, up=0.08, heel=20, stands=False), left_foot=Foot(forward=0.45),
            ),
            Key(1, forward=0.45, **feet(Foot(forward=0.45))),
        ),
    ),
    "turn": Action(
        2.2,
        (
            Key(0),
            Key(
                0.18, down=0.02, left=-0.08, turn=25, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                left_foot=Foot(forward=-0.08, up=0.08, left=-0.05, heel=15, outward=45, stands=False),
            ),
            Key(
                0.34, down=0.02, turn=65, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                right_foot=Foot(heel=15, outward=-10), left_foot=HALF_LEFT,
            ),
            Key(
                0.54, down=0.02, left=0.04, turn=115, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                right_foot=Foot(forward=0.14, up=0.1, left=0.2, heel=20, outward=-100, stands=False),
                left_foot=HALF_LEFT,
            ),
            Key(
                0.7, down=0.02, left=-0.02, turn=150, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                right_foot=HALF_RIGHT, left_foot=HALF_LEFT._replace(heel=12),
            ),
            Key(
                0.86, down=0.02, left=0.08, turn=172, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                right_foot=HALF_RIGHT,
                left_foot=Foot(forward=-0.1, up=0.08, left=-0.28, heel=15, outward=150, stands=False),
            ),
            Key(1, turn=180, right_foot=HALF_RIGHT, left_foot=Foot(left=-0.389, outward=187)),
        ),
    ),
    "wave": Action(
        2.8,
        (
            Key(0),
            Key(0.2, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=80)),
            Key(0.31, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=55)),
            Key(0.42, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=110)),
            Key(0.53, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=55)),
            Key(0.64, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=110)),
            Key(0.77, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=65)),
            Key(1),
        ),
    ),
}  # fmt: skip


# --- performance ------------------------------------------------------------------------------------------------------


STRAIGHT = 0.9985  # longest reach in lengths of the leg: the knee keeps 6°
SIDES = {"left": 1.0, "right": -1.0}
RHYTHM, RISES = 0.25, 60.0  # the clavicle rises with the upper arm by this share, above this angle, degrees
# Limits of the joints, degrees: flexion of elbow and knee, inward rotation of the upper arm, wrist and ankle about x
# and z.
ELBOW, KNEE, INWARD = (0.0, 150.0), (6.0, 130.0), 100.0
WRIST, ANKLE = ((-75.0, -45.0), (75.0, 45.0)), ((-40.0, -35.0), (60.0, 35.0))
CLEARANCE = 0.03  # of feet that swing, above the floor, m
YAW = 6.0  # largest departure of a standing foot from its planned direction, degrees
PLACED = (-0.4, 0.6), (-0.5, 0.5)  # departures of standing feet outward and forward, in distances of a hip


class Leg(NamedTuple):
    """Lengths of a leg, m."""

    hip: np.ndarray  # (3,) from the root
    thigh: float
    shank: float
    foot: np.ndarray  # (3,) from the ankle to the ball

    @classmethod
    def of(cls, skeleton: Skeleton, side: str) -> "Leg":
        offset = dict(zip(skeleton.joint_names, skeleton.offsets.copy(), strict=True))  # writable for scipy
        thigh, shank = (float(np.linalg.norm(offset[f"{side}_{name}"])) for name in ("thigh", "shank"))
        return cls(offset[f"{side}_pelvis"], thigh, shank, offset[f"{side}_foot"])

    @property
    def length(self) -> float:
        """From hip to ankle."""
        return self.thigh + self.shank


class Track(NamedTuple):
    """A foot over time."""

    ball: np.ndarray  # (n, 3), m
    rotation: Rotation  # (n,), in the world
    contact: np.ndarray  # (n,) the number of the place where it stands, −1 while it swings


def perform(
    skeleton: Skeleton, action: Action, departures: np.ndarray, duration: float, late: float, frame_rate: float
) -> Motion:
    """Generate a motion of the humanoid.

    `departures` (n_keys, n_dofs) are rotations about the joints' own axes, rad; `late` is the share of the duration by
    which the middle of the action is late.
    """
    keys, legs = action.keys, {side: Leg.of(skeleton, side) for side in SIDES}
    column = {name: k for k, name in enumerate(skeleton.dof_names)}
    own = {b.name: departures[:, [column[f"{b.name}_r{axis}"] for axis in b.dofs]] for b in skeleton.bones if b.dofs}
    turned = np.radians([(key.turn, key.tilt) for key in keys])
    position, feet = _stand(keys, legs, Rotation.from_euler("YX", turned), own)
    joints = _upper_joints(keys, own)
    for side, foot in feet.items():
        solved = solve_leg(legs[side], position, Rotation.from_euler("YX", turned), foot.ball, foot.rotation)
        joints |= {f"{side}_{name}": values for name, values in solved.items()}
        stands, free = (foot.contact >= 0)[:, None], np.clip(solved["foot"], *np.radians(ANKLE))
        joints[f"{side}_foot"] = np.where(stands, solved["foot"], free)
        joints[f"{side}_toes"] = np.where(stands, solved["toes"], own[f"{side}_toes"])

    share = np.array([key.time for key in keys])
    at = duration * (share + late * 4.0 * share * (1.0 - share))
    times = np.arange(int(duration * frame_rate) + 1) / frame_rate
    before = np.clip(np.searchsorted(at, times, side="right") - 1, 0, len(at) - 2)

    def between(values: np.ndarray | Rotation) -> np.ndarray | Rotation:
        if isinstance(values, Rotation):
            middle = values.mean()
            return middle * Rotation.from_rotvec(between((middle.inv() * values).as_rotvec()))
        return PchipInterpolator(at, values)(np.minimum(times, at[-1]))

    position, turned = between(position), between(turned)
    pelvis, moving = Rotation.from_euler("YX", turned), {name: between(values) for name, values in joints.items()}
    tracks = {
        side: Track(
            between(foot.ball),
            between(foot.rotation),
            np.where(foot.contact[1:] == foot.contact[:-1], foot.contact[1:], -1)[before],
        )
        for side, foot in feet.items()
    }
    position = _within_reach(position, pelvis, tracks, legs)
    for side, foot in tracks.items():
        stands = foot.contact >= 0
        for name, values in solve_leg(legs[side], position, pelvis, foot.ball, foot.rotation).items():
            moving[f"{side}_{name}"][stands] = values[stands]
    columns = [
        continuous_columns(bone, joint) if isinstance(joint := moving[bone.name], Rotation) else joint
        for bone in skeleton.bones
        if bone.dofs
    ]
    return Motion(skeleton, np.concatenate(columns, axis=1), frame_rate, position, turned, "YX")


def _stand(
    keys: Sequence[Key], legs: dict[str, Leg], pelvis: Rotation, own: dict[str, np.ndarray]
) -> tuple[np.ndarray, dict[str, Track]]:
    """The positions (n_keys, 3) of the pelvis and the feet at the key poses.

    The vector from hip to ankle departs with the hip and the knee. Feet that stand depart within bounds, and stay; the
    pelvis is above them as planned, and as high as the knees are bent.
    """
    length, ankle = legs["left"].length, -float(legs["left"].foot[1])
    position = np.array([(length * k.left, ankle + length * (1.0 - k.down), length * k.forward) for k in keys])
    feet, shifts, stands = {}, np.zeros((2, len(keys), 3)), np.zeros((2, len(keys)), dtype=bool)
    for i, (side, sign) in enumerate(SIDES.items()):
        leg, foot = legs[side], _plan([getattr(key, f"{side}_foot") for key in keys], legs[side], sign)
        vector = pelvis.inv().apply(foot.ball - foot.rotation.apply(leg.foot) - position) - leg.hip
        planned = np.minimum(np.linalg.norm(vector, axis=1), STRAIGHT * leg.length)
        reached = reach_of(leg, np.clip(knee_of(leg, planned) + own[f"{side}_shank"][:, 0], *np.radians(KNEE)))
        away = pelvis.apply(Rotation.from_rotvec(own[f"{side}_thigh"]).apply((reached / planned)[:, None] * vector))
        away -= pelvis.apply(vector)
        stands[i] = foot.contact >= 0
        turn, hip = (
            Rotation.from_rotvec(np.outer(np.arctan2(*pelvis.apply([0.0, 0.0, 1.0]).T[[0, 2]]), [0.0, 1.0, 0.0])),
            abs(leg.hip[0]),
        )
        outward, _, forward = turn.inv().apply(away).T
        placed = np.stack(
            [sign * np.clip(sign * outward / hip, *PLACED[0]), 0 * forward, np.clip(forward / hip, *PLACED[1])], 1
        )
        placed, yaw = turn.apply(hip * placed), np.clip(own[f"{side}_thigh"][:, 1], *np.radians([-YAW, YAW]))
        for k in range(1, len(keys)):  # a foot that stands stays
            if stands[i, k] and foot.contact[k] == foot.contact[k - 1]:
                placed[k], yaw[k] = placed[k - 1], yaw[k - 1]
        shifts[i] = placed + np.outer(reached - planned, [0.0, 1.0, 0.0])
        turns = Rotation.from_rotvec(np.where(stands[i], yaw, 0.0)[:, None] * [0.0, 1.0, 0.0])
        rolls = Rotation.from_rotvec(
            np.where(stands[i], 0.0, own[f"{side}_foot"].T).T @ [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
        )
        feet[side] = Track(
            foot.ball + np.where(stands[i][:, None], placed, away), turns * foot.rotation * rolls, foot.contact
        )
    n = stands.sum(axis=0)
    shift = (shifts * stands[..., None]).sum(axis=0) / np.maximum(n, 1)[:, None]
    shift[[key.sits for key in keys], 1] = 0.0
    for flight in np.flatnonzero(n == 0):
        shift[flight] = shift[flight - 1]
    for i, side in enumerate(SIDES):
        ball = feet[side].ball
        ball[~stands[i]] += shift[~stands[i]]
        ball[:, 1] = np.where(stands[i], ball[:, 1], np.maximum(ball[:, 1], CLEARANCE))
    return _within_reach(position + shift, pelvis, feet, legs), feet


def _plan(feet: Sequence[Foot], leg: Leg, sign: float) -> Track:
    """A foot at the key poses as planned."""
    from_hip = leg.length * np.array([(foot.left, foot.up, foot.forward) for foot in feet])
    yaw, heel = np.radians([(sign * foot.outward, foot.heel) for foot in feet]).T
    flat = Rotation.from_rotvec(np.outer(yaw, [0.0, 1.0, 0.0]))
    ball = leg.hip + from_hip + flat.apply(leg.foot * [1.0, 0.0, 1.0])
    places = [(foot.forward, foot.up, foot.left, foot.outward) if foot.stands else None for foot in feet]
    numbers = np.cumsum([0, *(a != b for a, b in pairwise(places))])
    contact = np.where([foot.stands for foot in feet], numbers, -1)
    return Track(ball, flat * Rotation.from_rotvec(np.outer(heel, [1.0, 0.0, 0.0])), contact)


def _within_reach(position: np.ndarray, pelvis: Rotation, feet: dict[str, Track], legs: dict[str, Leg]) -> np.ndarray:
    """The positions of the pelvis, lowered where a standing leg would be too long."""
    move = np.zeros(len(position))
    for side, foot in feet.items():
        leg = legs[side]
        away = foot.ball - foot.rotation.apply(leg.foot) - position - pelvis.apply(leg.hip)
        most = np.sqrt(np.maximum((STRAIGHT * leg.length) ** 2 - away[:, 0] ** 2 - away[:, 2] ** 2, 0.0))
        move = np.where(foot.contact >= 0, np.minimum(move, most + away[:, 1]), move)
    return position + np.outer(move, [0.0, 1.0, 0.0])


def _upper_joints(keys: Sequence[Key], own: dict[str, np.ndarray]) -> dict[str, Rotation | np.ndarray]:
    """The joints of trunk and arms: rotations (n_keys,), or angles (n_keys, n_dofs), rad."""
    trunk = np.array([(key.lean, key.twist, key.bend) for key in keys])
    nod = np.array([(key.nod, 0.0, 0.0) for key in keys])
    joints: dict[str, Rotation | np.ndarray] = {}
    for name, whole in (("abdomen", trunk), ("chest", trunk), ("neck", nod), ("head", nod)):
        joints[name] = Rotation.from_euler("xyz", whole / 2.0, degrees=True) * Rotation.from_rotvec(own[name])
    for side, sign in SIDES.items():
        arms: list[Arm] = [getattr(key, f"{side}_arm") for key in keys]
        plane, raised, inward, elbow = np.radians([(arm.plane, arm.raised, arm.inward, arm.elbow) for arm in arms]).T
        axis = np.stack([-np.cos(plane), np.zeros(len(arms)), sign * np.sin(plane)], axis=1)
        swing, turn = Rotation.from_rotvec(raised[:, None] * axis), own[f"{side}_upper_arm"] * [1.0, 0.0, 1.0]
        about = np.clip(own[f"{side}_upper_arm"][:, 1] - sign * inward, *np.radians([-INWARD, INWARD]))
        about_y = Rotation.from_rotvec(np.outer(about, [0.0, 1.0, 0.0]))
        joints[f"{side}_upper_arm"] = swing * Rotation.from_rotvec(turn) * about_y
        rises = np.maximum(0.0, raised - np.radians(RISES)) * RHYTHM
        joints[f"{side}_clavicle"] = np.outer(rises, [0.0, sign]) + own[f"{side}_clavicle"]
        joints[f"{side}_forearm"] = -np.clip(elbow[:, None] - own[f"{side}_forearm"], *np.radians(ELBOW))
        joints[f"{side}_hand"] = np.clip(own[f"{side}_hand"], *np.radians(WRIST))
    return joints


# --- inverse kinematics of the legs, in closed form -------------------------------------------------------------------


def knee_of(leg: Leg, distance: np.ndarray) -> np.ndarray:
    """The flexion of the knee, rad, at a distance from hip to ankle."""
    cosine = (leg.thigh**2 + leg.shank**2 - distance**2) / (2.0 * leg.thigh * leg.shank)
    return np.pi - np.arccos(np.clip(cosine, -1.0, 1.0))


def reach_of(leg: Leg, knee: np.ndarray) -> np.ndarray:
    """The distance from hip to ankle at a flexion of the knee."""
    return np.sqrt(leg.thigh**2 + leg.shank**2 + 2.0 * leg.thigh * leg.shank * np.cos(knee))


def solve_leg(
    leg: Leg, root: np.ndarray, pelvis: Rotation, ball: np.ndarray, foot: Rotation
) -> dict[str, Rotation | np.ndarray]:
    """The joints of a leg with the ball of the foot at `ball` (n, 3) and the foot rotated as `foot`.

    A leg has six dofs, as the foot has: the knee gives the distance from hip to ankle, the hip its direction and the
    rotation of the leg about it, which follows from the foot because the ankle does not rotate about the shank. A
    straight leg reaches for a foot too far away. Of two solutions, the knee points less to the side.
    """
    to_ankle = pelvis.inv().apply(ball - foot.apply(leg.foot) - root) - leg.hip
    distance = np.linalg.norm(to_ankle, axis=1, keepdims=True)
    direction = to_ankle / distance
    knee = knee_of(leg, np.minimum(distance[:, 0], STRAIGHT * leg.length))
    bent = Rotation.from_rotvec(np.outer(knee, [1.0, 0.0, 0.0]))
    # The leg with its hip at zero, in the plane of y and z, and with its knee in front.
    zero = np.array([0.0, -leg.thigh, 0.0]) + bent.apply([0.0, -leg.shank, 0.0])
    before = _frames(zero / np.linalg.norm(zero, axis=1, keepdims=True))
    in_front = _frames(direction) * before.inv()
    # Rotate it about the line from hip to ankle until the foot's x and the shank's z are perpendicular.
    z, across = (in_front * bent).apply([0.0, 0.0, 1.0]), (pelvis.inv() * foot).apply([1.0, 0.0, 0.0])
    along = np.sum(z * direction, axis=1, keepdims=True) * direction
    constant, cosines, sines = (
        np.sum(part * across, axis=1) for part in (along, z - along, np.cross(direction, z - along))
    )
    phase, size = np.arctan2(sines, cosines), np.hypot(cosines, sines)
    opening = np.arccos(np.clip(-constant / np.maximum(size, 1e-12), -1.0, 1.0))
    both = np.angle(np.exp(1j * np.stack([phase + opening, phase - opening])))
    about = np.take_along_axis(both, np.abs(both).argmin(axis=0)[None], axis=0)[0]
    hip = Rotation.from_rotvec(about[:, None] * direction) * in_front
    R = ((hip * bent).inv() * pelvis.inv() * foot).as_matrix()
    ankle = np.stack([np.arctan2(R[:, 2, 1], R[:, 2, 2]), np.arctan2(R[:, 1, 0], R[:, 0, 0])], axis=1)
    toes = -np.arcsin(np.clip(-foot.apply([0.0, 0.0, 1.0])[:, 1:2], -1.0, 1.0))  # flat while the heel is up
    return {"thigh": hip, "shank": knee[:, None], "foot": ankle, "toes": toes}


def _frames(along: np.ndarray) -> Rotation:
    """Rotations of -y to unit vectors (n, 3) that keep x as near as possible."""
    x = np.array([1.0, 0.0, 0.0]) - along[:, :1] * along
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return Rotation.from_matrix(np.stack([x, -along, np.cross(x, -along)], axis=2))
