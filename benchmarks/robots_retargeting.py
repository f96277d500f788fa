"""People to robots: how near is a robot to a person's motion, and how many frames a second?

    python benchmarks/robots_retargeting.py --robots FOLDER OF MJCF FILES [--cmu FOLDER OF CMU FILES] [--quick]

Each motion of CMU (or generated gait) as it is, at its own frame rate, on each robot, by ``retarget_to_robot``.
What a robot does is measured by MuJoCo's forward kinematics at the places of its links, and what the person does at
joints whose names are typed here:

- frames a second of the whole call, warm, by the clock of this process, on one thread;
- angles outside the limits of the file, and the fastest angle;
- soles and hands from where they shall be, mm, mean and that of 95 %;
- thighs, shanks, upper arms and forearms from those of the person, degrees, mean and that of 95 %;
- feet that stand: how far toes are from their mean place while they do, mm, and how fast they move, mm/s;
- jumps: by how much toes, and the pelvis, move from one frame to the next more than the person's do within 0.025 s of
  it, in the size of the robot, the largest of each motion, mm; the lowest corner of a sole above the floor, mm.

Then mink with MuJoCo on the same frames and the same places, in turns: tasks of position and orientation for pelvis,
chest and feet, of position for knees, elbows, wrists and hands, a task of the rest pose, `ConfigurationLimit`, daqp;
with one and two iterations a frame, and with as many as it needs to come as near (the weighted sum of squares within
5 %). It gets its targets made; the whole call of skpose makes its own.

Controls: noise; a person who turns by 360°; a motion in a world that is rotated; limits that are ignored; feet that are
not held.
"""

import time
import warnings
from dataclasses import replace
from pathlib import Path
from tempfile import mkdtemp

import common
import numpy as np
import stand_in
from scipy.ndimage import maximum_filter1d
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics
from skpose.datasets import load_cmu, make_gait
from skpose.robots import _targets, load_robot, retarget_to_robot
from skpose.robots._contacts import Held
from skpose.robots._person import to_vertical
from skpose.robots._solver import LEVER, solve
from skpose.robots._stance import Place, sole_of, stances_of

ROBOTS = ("unitree_g1", "booster_t1", "engineai_pm01", "galaxea_r1pro")
SIDES = ("left", "right")
BONES = (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
ASF = {"hip": "{}hipjoint", "knee": "{}femur", "ankle": "{}tibia"}
ASF |= {"shoulder": "{}clavicle", "elbow": "{}humerus", "wrist": "{}wrist"}
HUMANOID = {"hip": "{}_pelvis", "knee": "{}_thigh", "ankle": "{}_shank"}
HUMANOID |= {"shoulder": "{}_clavicle", "elbow": "{}_upper_arm", "wrist": "{}_forearm"}
MOST_ITER, NEAR = 20, 1.05
RACE = 150  # frames of each motion
GAIN, LM_DAMPING, DAMPING = 0.95, 1e-3, 1e-6


class Robot:
    """A robot as a skeleton and as a MuJoCo model with a site at each place of a target."""

    def __init__(self, path):
        import mujoco

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
    vertical = to_vertical(motion.up)
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
    positions = positions @ rotations.transpose(0, 2, 1) @ to_vertical(motion.up).T
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
        self.aim = _targets.aim_at(motion, robot.skeleton, theirs, ours, None, "enforce")
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
        self.wished = np.stack(targets.positions, axis=1)
        self.weights, self.count = np.array(targets.weights), len(targets.places)
        places = [*targets.places, *named, *corners]
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
        groups, at = self.aim.targets.groups, dict(zip(self.marks, named.swapaxes(0, 1), strict=True))
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


class Mink:
    """mink's usual loop on the same places."""

    def __init__(self, case):
        import mink

        self.mink, self.case = mink, case
        targets, ours = case.aim.targets, case.ours
        self.frames, sites, axes = [], [], []  # (position, axes, position cost, orientation cost)
        links = targets.groups["links"]
        done = set()
        for first in links[::4]:
            group = links[links.index(first) : links.index(first) + 4]
            corners = [targets.positions[i] for i in group]
            place = targets.places[group[0]]
            middle = (place.at_zero + targets.places[group[1]].at_zero) / 2.0
            x = (corners[0] - corners[1]) / (2.0 * LEVER)
            at = (corners[0] + corners[1]) / 2.0
            y = (corners[2] - at) / LEVER
            w = targets.weights[group[0]]
            self._add(sites, axes, place._replace(at_zero=middle), ours.axes, at, x, y, 4 * w, 3 * w * LEVER**2)
            done |= set(group)
        for side in case.aim.legs:
            group = targets.groups[f"{side} foot"]
            left, right, heel = (targets.positions[i] for i in group)
            places = [targets.places[i] for i in group]
            x = (left + right) / 2.0 - heel
            length = np.linalg.norm(x, axis=1, keepdims=True)
            y = (left - right) / np.linalg.norm(left - right, axis=1, keepdims=True)
            middle = np.mean([place.at_zero for place in places], axis=0)
            w = targets.weights[group[0]]
            self._add(
                sites,
                axes,
                places[0]._replace(at_zero=middle),
                ours.feet[side][1],
                (left + right + heel) / 3.0,
                x / length,
                y,
                3 * w,
                0.5 * w * float(length.mean()) ** 2,
            )
            done |= set(group)
        for i, place in enumerate(targets.places):
            if i not in done:
                self._add(sites, axes, place, np.eye(3), targets.positions[i], None, None, targets.weights[i], 0.0)
        self.model = case.robot.with_sites(sites, axes)
        self.tasks = [
            mink.FrameTask(f"place {i}", "site", np.sqrt(p), np.sqrt(o), lm_damping=LM_DAMPING)
            for i, (_, _, p, o) in enumerate(self.frames)
        ]
        self.posture = mink.PostureTask(self.model, cost=_targets.STIFFNESS)
        self.limits = [mink.ConfigurationLimit(self.model, gain=GAIN)]

    def _add(self, sites, axes, place, own, at, x, y, position_cost, orientation_cost):
        turned = None
        if x is not None:
            turned = Rotation.from_matrix(np.stack([x, y, np.cross(x, y)], axis=2))
        sites.append(place)
        axes.append(own)
        self.frames.append((at, turned, position_cost, orientation_cost))

    def run(self, n_iter, costs=None):
        """Return qpos of all frames, seconds and iterations a frame; with costs, iterations until they are met."""
        mink, n = self.mink, len(self.frames[0][0])
        configuration = mink.Configuration(self.model)
        qpos, total = np.empty((n, self.model.nq)), 0
        start = time.process_time()
        for i in range(n):
            for task, (at, turned, _, _) in zip(self.tasks, self.frames, strict=True):
                so3 = mink.SO3.identity() if turned is None else mink.SO3.from_matrix(turned[i].as_matrix())
                task.set_target(mink.SE3.from_rotation_and_translation(so3, at[i]))
            if i == 0:
                self.posture.set_target_from_configuration(configuration)
                q = configuration.q.copy()
                q[:3] = self.frames[0][0][0]
                q[3:7] = self.frames[0][1][0].as_quat(scalar_first=True)
                configuration.update(q)
            for k in range(MOST_ITER if costs is not None or i == 0 else n_iter):
                v = mink.solve_ik(
                    configuration, [*self.tasks, self.posture], 1.0, "daqp", damping=DAMPING, limits=self.limits
                )
                configuration.integrate_inplace(v, 1.0)
                total += 1
                if costs is not None and k < MOST_ITER - 1 and self._cost(configuration, i) <= NEAR * costs[i] + 1e-9:
                    break
            qpos[i] = configuration.q
        return qpos, time.process_time() - start, total / n

    def _cost(self, configuration, i):
        """Return the weighted sum of squares, of the places by their own positions and axes."""
        total = 0.0
        for task, (_, _, p, o) in zip(self.tasks, self.frames, strict=True):
            error = task.compute_error(configuration)
            total += p * error[:3] @ error[:3] + o * error[3:] @ error[3:]
        return total


def race(robot, motions, names, repeats):
    """Print how fast and how near skpose and mink are on the same frames."""
    cases = [Case(robot, motion[:RACE], names) for motion in motions]
    minks = [Mink(case) for case in cases]
    frames = sum(len(case.motion) for case in cases)
    ours = [retarget_to_robot(case.motion, robot.skeleton) for case in cases]
    costs = []
    for mink, motion in zip(minks, ours, strict=True):
        configuration, cost = mink.mink.Configuration(mink.model), []
        for i, q in enumerate(configurations(mink.model, motion)):
            configuration.update(q)
            for task, (at, turned, _, _) in zip(mink.tasks, mink.frames, strict=True):
                so3 = mink.mink.SO3.identity() if turned is None else mink.mink.SO3.from_matrix(turned[i].as_matrix())
                task.set_target(mink.mink.SE3.from_rotation_and_translation(so3, at[i]))
            cost.append(mink._cost(configuration, i))
        costs.append(np.array(cost))
    seconds = {"skpose, whole call": [], "skpose, its solver": []}
    settings = {"mink, 1 iteration": (1, False), "mink, 2 iterations": (2, False), "mink, as near": (1, True)}
    seconds |= {name: [] for name in settings}
    found = {name: [None] * len(cases) for name in settings}
    iterations = dict.fromkeys(settings, 0.0)
    for _ in range(repeats):
        start = time.process_time()
        for case in cases:
            retarget_to_robot(case.motion, robot.skeleton)
        seconds["skpose, whole call"].append(time.process_time() - start)
        start = time.process_time()
        for case in cases:
            aim = case.aim
            solve(aim.skeleton, aim.targets, aim.bent, _targets.STIFFNESS, case.motion.times, _targets.FASTEST)
        seconds["skpose, its solver"].append(time.process_time() - start)
        for name, (n_iter, as_near) in settings.items():
            spent = 0.0
            for i, mink in enumerate(minks):
                qpos, used, per_frame = mink.run(n_iter, costs[i] if as_near else None)
                found[name][i], iterations[name] = (qpos, mink.model), per_frame
                spent += used
            seconds[name].append(spent)
    results = {"skpose, whole call": [case.measure(motion) for case, motion in zip(cases, ours, strict=True)]}
    for name in settings:
        results[name] = []
        for case, motion, (qpos, model) in zip(cases, ours, found[name], strict=True):
            columns = [model.joint(joint).qposadr[0] for joint in motion.skeleton.dof_names]
            other = replace(motion, angles=qpos[:, columns])
            results[name].append(case.measure_qpos(qpos) | violations(other))
    for name, values in seconds.items():
        more = f" ({iterations[name]:.1f} iterations)" if name in iterations else ""
        measured = in_words(results[name]) if name in results else ""
        print(f"  {name}{more}: {frames / np.median(values):,.0f} frames/s; {measured}")


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
    for label, one in (("walk", motion), ("bending", bend)):
        free = violations(retarget_to_robot(one, robot.skeleton, joint_limits="ignore"))
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
    dataset = load_cmu(options.cmu) if options.cmu else make_gait(2, 1, random_state=0)
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
        every_motion(robot, dataset, names, repeats)
        print(" on the same frames, in turns:")
        try:
            race(robot, dataset[: 2 if options.quick else 6], names, 1 if options.quick else 2)
        except ImportError as error:
            print(f"  mink left out: {error}")
        print(" controls:")
        controls(robot, dataset[0], dataset[5 if len(dataset) > 5 else 0], names)


if __name__ == "__main__":
    main()
