"""Robots: kinematics against MuJoCo's, and motions of people on them.

    python benchmarks/robots.py [--robots FOLDER OF MJCF FILES] [--cmu FOLDER OF CMU FILES] [--quick]

First the bodies of random configurations within the joint limits are compared with `mj_kinematics`, and their
derivatives with `mj_jacBody`: the largest differences, relative to the root.

Then each motion of CMU (or generated gait) on each robot by `retarget_to_robot`, measured by MuJoCo's forward
kinematics at the links, and at joints of the person whose names are typed here:

- frames a second of the whole call, warm, CPU time on one thread;
- angles outside the limits, and the fastest angle;
- errors of soles and hands, mm, and of the directions of limbs, degrees: mean and 95th percentile;
- standing feet: distance of the toes from their mean place, mm, and their speed, mm/s;
- jumps: steps of toes and pelvis beyond the person's within 0.025 s, the largest of each motion, mm; the lowest corner
  of a sole above the floor, mm.

Controls: noise; a person who turns by 360°; a motion in a world that is rotated; limits that are ignored; feet that are
not held.
"""

import time
import warnings
from dataclasses import replace
from pathlib import Path
from tempfile import mkdtemp

import common
import mujoco
import numpy as np
import stand_in
from scipy.ndimage import maximum_filter1d
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics
from skpose.datasets import load_cmu, make_gait
from skpose.kinematics import position_jacobian
from skpose.robots import _targets, load_robot, retarget_to_robot
from skpose.robots._contacts import Held
from skpose.robots._stance import Place, sole_of, stances_of
from skpose.skeleton._upright import axes_with_up_last

ROBOTS = ("unitree_g1", "booster_t1", "engineai_pm01", "galaxea_r1pro")
SIDES = ("left", "right")
BONES = (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
ASF = {"hip": "{}hipjoint", "knee": "{}femur", "ankle": "{}tibia"}
ASF |= {"shoulder": "{}clavicle", "elbow": "{}humerus", "wrist": "{}wrist"}
HUMANOID = {"hip": "{}_pelvis", "knee": "{}_thigh", "ankle": "{}_shank"}
HUMANOID |= {"shoulder": "{}_clavicle", "elbow": "{}_upper_arm", "wrist": "{}_forearm"}
N_CONFIGURATIONS, CHUNK = 10_000, 500
WITHIN = 1e-13  # m, and m/rad


def model_of(text, read):
    """Compile a model whose bodies have a mass, and none of which is fused with another."""
    spec = read(text)
    spec.compiler.fusestatic = False
    for geom in list(spec.geoms):
        spec.delete(geom)
    for body in spec.bodies[1:]:
        body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
        body.fullinertia = np.full(6, np.nan)
    return spec.compile()


def random_configurations(skeleton, n, rng):
    """Return random poses within the limits."""
    limits = np.tile([-np.pi, np.pi], (skeleton.n_dofs, 1)) if skeleton.limits is None else skeleton.limits
    limits = np.clip(limits, -np.pi, np.pi)
    return rng.uniform(limits[:, 0], limits[:, 1], size=(n, skeleton.n_dofs))


class Reference:
    """Positions and Jacobians of a robot's bodies by MuJoCo, relative to its root, one configuration at a time."""

    def __init__(self, skeleton, model):
        self.model, self.data = model, mujoco.MjData(model)
        joints = [model.joint(name) for name in skeleton.dof_names]
        self.columns, self.rates = [j.qposadr[0] for j in joints], [j.dofadr[0] for j in joints]
        self.bodies = {name: model.body(name).id for name in skeleton.joint_names if has_body(model, name)}
        self.rows = [skeleton.joint_names.index(name) for name in self.bodies]
        self.root = model.body_parentid[min(self.bodies.values())]
        self._jacobian = np.zeros((3, model.nv))

    def place(self, pose):
        self.data.qpos[:] = self.model.qpos0
        self.data.qpos[self.columns] = pose
        mujoco.mj_kinematics(self.model, self.data)

    def positions(self):
        rotation = self.data.xmat[self.root].reshape(3, 3)
        return (self.data.xpos[list(self.bodies.values())] - self.data.xpos[self.root]) @ rotation

    def jacobian(self):
        mujoco.mj_comPos(self.model, self.data)
        rotation, found = self.data.xmat[self.root].reshape(3, 3), []
        for body in self.bodies.values():
            mujoco.mj_jacBody(self.model, self.data, self._jacobian, None, body)
            found.append(rotation.T @ self._jacobian[:, self.rates])
        return np.stack(found)


def has_body(model, name):
    return mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name) >= 0


def differences(skeleton, model, n):
    """The largest differences of positions, m, and of Jacobians, m/rad."""
    reference, rng = Reference(skeleton, model), np.random.default_rng(0)
    positions = jacobians = 0.0
    for start in range(0, n, CHUNK):
        X = random_configurations(skeleton, min(CHUNK, n - start), rng)
        P = forward_kinematics(X, skeleton)[:, reference.rows]
        J = position_jacobian(X, skeleton).reshape(len(X), skeleton.n_joints, 3, -1)[:, reference.rows]
        for pose, p, j in zip(X, P, J, strict=True):
            reference.place(pose)
            positions = max(positions, np.abs(reference.positions() - p).max())
            jacobians = max(jacobians, np.abs(reference.jacobian() - j).max())
    return positions, jacobians


def exactness(path, n):
    """Print how far kinematics are from MuJoCo's."""
    skeleton, model = load_robot(path), model_of(str(path), mujoco.MjSpec.from_file)
    positions, jacobians = differences(skeleton, model, n)
    print(f"  {n:,} random configurations: positions {positions:.1e} m, Jacobian {jacobians:.1e} m/rad")
    assert max(positions, jacobians) <= WITHIN


class Robot:
    """A robot as a skeleton and as a MuJoCo model with a site at each place of a target."""

    def __init__(self, path):
        self.mujoco, self.path = mujoco, str(path)
        self.model = mujoco.MjModel.from_xml_path(self.path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of a mobile base, which moves the root
            self.skeleton = load_robot(path, root=self.model.body(1).name)

    def with_sites(self, places, axes):
        """Return a model whose root is free, with sites at places, and the name of each site's frame."""
        spec = self.mujoco.MjSpec.from_file(self.path)
        bodies = spec.worldbody.first_body()
        root = bodies
        for joint in list(root.joints):
            spec.delete(joint)
        root.add_freejoint()
        if root.mass == 0.0:
            root.mass, root.inertia, root.explicitinertial = 1.0, np.ones(3), True
        index = {name: j for j, name in enumerate(self.skeleton.joint_names)}
        zero, frames = rest_of(self.skeleton)
        for i, (place, own) in enumerate(zip(places, axes, strict=True)):
            link, rotation = place.joint, np.eye(3) if own is None else own
            body = root if link < 0 else next(b for b in spec.bodies if index.get(b.name, -2) == link)
            turn = frames[link].T
            site = body.add_site(name=f"place {i}", pos=turn @ (place.at_zero - zero[link]))
            site.quat = Rotation.from_matrix(turn @ rotation).as_quat(scalar_first=True)
        return spec.compile()


def rest_of(skeleton):
    """Return the positions of the joints at angle zero and their axes; the last are the root's."""
    frames = [np.eye(3)]
    for parent, rest in zip(skeleton.parents, skeleton.rest_rotations, strict=True):
        frames.append(frames[parent + 1] @ rest)
    positions = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]
    return np.vstack([positions, np.zeros(3)]), [*frames[1:], frames[0]]


def configurations(model, motion):
    """Return the motion as MuJoCo's qpos in a world whose last axis is the vertical."""
    vertical = np.eye(3)[axes_with_up_last(motion.up)]
    rotations = vertical @ Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    qpos = np.tile(model.qpos0, (len(motion), 1))
    qpos[:, :3] = motion.root_positions @ vertical.T
    qpos[:, 3:7] = Rotation.from_matrix(rotations).as_quat(scalar_first=True)
    for name, column in zip(motion.skeleton.dof_names, motion.angles.T, strict=True):
        qpos[:, model.joint(name).qposadr[0]] = column
    return qpos


def sites_of(mujoco, model, qpos, count):
    """Return the positions of sites by MuJoCo."""
    data, out = mujoco.MjData(model), np.empty((len(qpos), count, 3))
    ids = [model.site(f"place {i}").id for i in range(count)]
    for i, q in enumerate(qpos):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        out[i] = data.site_xpos[ids]
    return out


def person_limbs(motion, names):
    """Return the directions of the person's limbs in the world whose last axis is the vertical."""
    positions = forward_kinematics(motion.angles, motion.skeleton)
    rotations = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    positions = positions @ rotations.transpose(0, 2, 1) @ np.eye(3)[axes_with_up_last(motion.up)].T
    at = {}
    for side in SIDES:
        for mark, pattern in names.items():
            name = pattern.format(side[0] if pattern.startswith("{}") and "_" not in pattern else side)
            at[side, mark] = positions[:, motion.skeleton.joint_names.index(name)]
    return at


def directions(at, bones):
    vectors = np.stack([at[side, end] - at[side, start] for side in SIDES for start, end in bones], axis=1)
    return vectors / np.linalg.norm(vectors, axis=2, keepdims=True)


class Case:
    """A motion, where a robot shall be, and the model that measures where it is."""

    def __init__(self, robot, motion, names):
        theirs, ours = stances_of(motion.skeleton, robot.skeleton, None)
        self.robot, self.motion, self.ours = robot, motion, ours
        self.aim = _targets.aim_at(motion, robot.skeleton, theirs, ours, None)
        self.bones = [pair for pair in BONES if f"left_{pair[0]}" in ours.places]
        self.marks = [(side, mark) for side in SIDES for mark in {m: 0 for pair in self.bones for m in pair}]
        named = [ours.places[f"{side}_{mark}"] for side, mark in self.marks]
        corners = []
        for side in self.aim.legs:
            (joint, axes), ankle = ours.feet[side], ours.places[f"{side}_ankle"].at_zero
            corners += [Place(joint, ankle + axes @ corner) for corner in sole_of(ours, side).corners()]
        if corners:
            hips = [ours.places[f"{side}_hip"].at_zero for side in SIDES]
            corners.append(Place(ours.pelvis, np.mean(hips, axis=0)))
        targets = self.aim.targets
        self.wished = np.stack([target.position for target in targets], axis=1)
        self.weights, self.count = np.array([target.weight for target in targets]), len(targets)
        self.groups = {target.group: [] for target in targets}
        for i, target in enumerate(targets):
            self.groups[target.group].append(i)
        places = [*(target.place for target in targets), *named, *corners]
        self.n_places = len(places)
        self.model = robot.with_sites(places, [None] * len(places))
        self.person = directions(person_limbs(motion, names), self.bones)

    def measure(self, motion):
        """Return what is printed of a result."""
        qpos = configurations(self.model, motion)
        return self.measure_qpos(qpos) | violations(motion)

    def measure_qpos(self, qpos):
        points = sites_of(self.robot.mujoco, self.model, qpos, self.n_places)
        off = np.linalg.norm(points[:, : self.count] - self.wished, axis=2)
        named = points[:, self.count : self.count + len(self.marks)]
        groups, at = self.groups, dict(zip(self.marks, named.swapaxes(0, 1), strict=True))
        chords = np.linalg.norm(directions(at, self.bones) - self.person, axis=2)
        slides, speeds, lowest = [], [], []
        jumps = {name: [] for name in ("sole jumps", "pelvis jumps")}
        corners = points[:, self.count + len(self.marks) :]
        for i, side in enumerate(self.aim.legs):
            sole = corners[:, 4 * i : 4 * i + 4]
            lowest.append(sole[:, :, 2].min())
            jumps["sole jumps"].append(self._beyond(sole[:, 2:].mean(axis=1), side))
        if self.aim.legs:
            jumps["pelvis jumps"].append(self._beyond(corners[:, -1], "pelvis"))
        for side, leg in self.aim.legs.items():
            toes = points[:, groups[f"{side} foot"][:2]].mean(axis=1)
            for contact in leg.contacts:
                stood = toes[contact.first : contact.end]
                slides.append(np.linalg.norm(stood - stood.mean(axis=0), axis=1).max())
                if len(stood) > 1:
                    steps = np.linalg.norm(np.diff(stood, axis=0), axis=1)
                    speeds += (steps * self.motion.frame_rate).tolist()
        soles = [i for side in SIDES for i in groups.get(f"{side} foot", [])]
        return {
            "cost": (self.weights * off**2).sum(axis=1),
            "soles": off[:, soles].ravel(),
            "hands": off[:, groups["hands"]].ravel(),
            "limbs": np.degrees(2.0 * np.arcsin(np.minimum(chords / 2.0, 1.0))).ravel(),
            "slides": np.array(slides),
            "speeds": np.array(speeds),
            "lowest": np.array(lowest),
        } | {name: np.array(values) for name, values in jumps.items()}

    def _beyond(self, path, name):
        """Return the largest step of a path beyond those of the person's around it, m."""
        steps, theirs = (np.linalg.norm(np.diff(one, axis=0), axis=1) for one in (path, self.aim.paths[name]))
        around = 2 * int(np.ceil(0.025 * self.motion.frame_rate)) + 1
        return (steps - maximum_filter1d(theirs, around, mode="nearest")).max()


def violations(motion):
    """Return how many angles are outside their limits, by how much at most, degrees, and the fastest, rad/s."""
    limits = np.array(motion.skeleton.limits)
    beyond = np.maximum(limits[:, 0] - motion.angles, motion.angles - limits[:, 1])
    steps = np.diff(motion.angles, axis=0)[:, np.isfinite(limits).all(axis=1)]
    fastest = np.abs(steps).max(initial=0.0) * motion.frame_rate
    return {
        "outside": int((beyond > 0.0).sum()),
        "beyond": float(np.degrees(max(beyond.max(), 0.0))),
        "fastest": round(float(fastest), 6),
    }


def in_words(results):
    """Return the measures of some results together."""
    names = ("soles", "hands", "limbs", "slides", "speeds", "lowest", "sole jumps", "pelvis jumps")
    join = {name: np.concatenate([r[name] for r in results]) for name in names}
    parts = [f"outside limits {sum(r['outside'] for r in results)}"]
    parts += [f"fastest {max(r['fastest'] for r in results):.1f} rad/s"]
    for name, unit, factor in (("soles", "mm", 1e3), ("hands", "mm", 1e3), ("limbs", "°", 1.0)):
        if join[name].size:
            x = factor * join[name]
            parts.append(f"{name} {x.mean():.2f} {unit} (95 %: {np.percentile(x, 95):.2f}, most {x.max():.1f})")
    if join["slides"].size:
        x, v = 1e3 * join["slides"], 1e3 * join["speeds"]
        parts.append(
            f"{len(x)} times a foot stands: slides {x.mean():.2f} mm (95 %: {np.percentile(x, 95):.2f}, most "
            f"{x.max():.1f}), {v.mean():.1f} mm/s (95 %: {np.percentile(v, 95):.1f})"
        )
    for name in ("sole jumps", "pelvis jumps"):
        if join[name].size:
            x = 1e3 * join[name]
            parts.append(f"{name} median {np.median(x):.1f} mm (most {x.max():.1f}, {(x > 20).sum()} above 20 mm)")
    if join["lowest"].size:
        x = 1e3 * join["lowest"]
        parts.append(f"lowest corner {x.min():.1f} mm (median of feet {np.median(x):.1f})")
    return "; ".join(parts)


def every_motion(robot, dataset, names, repeats):
    """Print what all motions are on a robot."""
    cases = [Case(robot, motion, names) for motion in dataset]
    results = []
    for case in cases:
        results.append(case.measure(retarget_to_robot(case.motion, robot.skeleton)))
    seconds, frames = [], sum(len(motion) for motion in dataset)
    for _ in range(repeats):
        start = time.process_time()
        for motion in dataset:
            retarget_to_robot(motion, robot.skeleton)
        seconds.append(time.process_time() - start)
    print(f"  all: {frames / np.median(seconds):,.0f} frames/s; {in_words(results)}")
    for action in sorted(set(dataset.actions)):
        chosen = [r for r, one in zip(results, dataset.actions, strict=True) if one == action]
        print(f"  {action}: {in_words(chosen)}")


def controls(robot, motion, bend, names):
    """Print what should and should not be."""
    rng = np.random.default_rng(0)
    noise = replace(motion, angles=motion.angles + rng.normal(scale=0.5, size=motion.angles.shape))
    print(f"  noise of 0.5 rad on each angle: {violations(retarget_to_robot(noise, robot.skeleton))}")
    up = "xyz".index(motion.up)
    world = Rotation.from_rotvec(np.eye(3)[up] * 2.0)
    root = Rotation.from_euler(motion.root_axes, motion.root_angles)
    turned = replace(
        motion,
        root_positions=world.apply(motion.root_positions),
        root_angles=(world * root).as_euler("xyz"),
        root_axes="xyz",
    )
    first, second = (retarget_to_robot(one, robot.skeleton) for one in (motion, turned))
    there = np.degrees(np.abs(first.angles - second.angles).max())
    moved = 1e3 * np.abs(world.apply(first.root_positions) - second.root_positions).max()
    print(f"  the world rotated by 2 rad: angles differ by {there:.2g}°, the root by {moved:.2g} mm")
    circle = Rotation.from_rotvec(np.eye(3)[up] * np.linspace(0.0, 2.0 * np.pi, len(motion))[:, None])
    around = replace(
        motion,
        root_positions=circle.apply(motion.root_positions - motion.root_positions.mean(axis=0)),
        root_angles=(circle * root).as_euler("xyz"),
        root_axes="xyz",
    )
    result = retarget_to_robot(around, robot.skeleton)
    steps = Rotation.from_euler(result.root_axes, result.root_angles)
    largest = np.degrees((steps[1:] * steps[:-1].inv()).magnitude().max())
    wished = Rotation.from_euler("xyz", around.root_angles)
    largest_wished = np.degrees((wished[1:] * wished[:-1].inv()).magnitude().max())
    jump = np.degrees(np.abs(np.diff(result.root_angles, axis=0)).max())
    print(
        f"  turning by 360°: {violations(result)}; the root turns by {largest:.2f}° a frame at most, the person's "
        f"{largest_wished:.2f}°; its angles change by {jump:.2f}° at most"
    )
    free_robot = replace(robot.skeleton, bones=[bone._replace(limits=None) for bone in robot.skeleton.bones])
    for label, one in (("walk", motion), ("bending", bend)):
        free = violations(replace(retarget_to_robot(one, free_robot), skeleton=robot.skeleton))
        print(f"  {label}, limits ignored: {free['outside']} angles outside, by {free['beyond']:.1f}° at most")
    if "left_hip" in stances_of(motion.skeleton, robot.skeleton, None)[1].places:
        case = Case(robot, motion, names)
        held = case.measure(retarget_to_robot(motion, robot.skeleton))["slides"]
        hold = _targets.hold_foot
        _targets.hold_foot = lambda end, foot, *rest: Held(end, foot, np.zeros(len(end)), [])
        try:
            loose = case.measure(retarget_to_robot(motion, robot.skeleton))["slides"]
        finally:
            _targets.hold_foot = hold
        if held.size:  # on a treadmill feet stand nowhere
            print(f"  feet held: slide {1e3 * held.max():.2f} mm at most; not held: {1e3 * loose.max():.1f} mm")


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--cmu", help="CMU files, see load_cmu")
    arguments.add_argument("--robots", help="a folder of MJCF files; default: a robot of proportions of nobody")
    options = arguments.parse_args()
    common.print_machine()
    warnings.simplefilter("ignore")
    dataset = (
        load_cmu(options.cmu, rotations="file") if options.cmu else make_gait(2, 1, rotations="file", random_state=0)
    )
    names = ASF if options.cmu else HUMANOID
    if options.quick:
        dataset = dataset[:2]
    repeats = 1 if options.quick else 3
    print(dataset)
    folder = Path(options.robots or mkdtemp())
    if not options.robots:
        stand_in.write_robot(folder)
    for name in ROBOTS if options.robots else (stand_in.NAME,):
        path = folder / f"{name}.xml"
        if not path.exists():
            print(f"{name}: left out, there is no {path.name}")
            continue
        robot = Robot(path)
        print(f"\n{name}, {robot.skeleton}")
        exactness(path, 100 if options.quick else N_CONFIGURATIONS)
        every_motion(robot, dataset, names, repeats)
        print(" controls:")
        controls(robot, dataset[0], dataset[5 if len(dataset) > 5 else 0], names)


if __name__ == "__main__":
    main()
