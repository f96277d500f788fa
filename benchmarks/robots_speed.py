"""Distances between configurations of a robot: pairs a second, against other frames, MuJoCo and pinocchio.

`--robot FILE` is an MJCF file whose joints are hinges, such as the Unitree G1's; without it a humanoid of nobody's
proportions. "spatial" is computed for all pairs of random configurations inside the limits: by skpose; by skpose on the
frames of a first prototype, where each hinge is one about z in a turned frame; and for a person of 56 dofs. MuJoCo and
pinocchio place the links of every pose along every line, one at a time from Python, as users of them do; numpy adds up
the chords. All answers are compared.
"""

from tempfile import mkdtemp

import numpy as np
import stand_in
from common import medians, parser, print_machine
from scipy.spatial.transform import Rotation

from skpose import Skeleton, pose_distances
from skpose.datasets import load_cmu
from skpose.metrics import Spatial
from skpose.robots import load_robot
from skpose.skeleton import Bone

N, N_QUICK = 1000, 60
N_OTHERS = 6  # configurations of which all pairs are computed by the others
N_STEPS = 10
LINE = Spatial(N_STEPS, wrap=False)  # a robot with limits does not go past π


def on_turned_frames(robot):
    """Return the robot with each hinge about z, in frames of its own: rest rotations take z to the axis and back."""
    bones, back = [], {None: np.eye(3)}  # by the joint: from its axes to those of its frame
    for bone, rest in zip(robot.bones, robot.rest_rotations, strict=True):
        before = back[bone.parent] @ rest
        turned = np.eye(3) if bone.axis is None else Rotation.align_vectors([bone.axis], [[0, 0, 1]])[0].as_matrix()
        back[bone.name] = turned.T
        bones.append(
            Bone(
                bone.name,
                bone.parent,
                back[bone.parent] @ bone.offset,
                "z" if bone.dofs else "",
                before @ turned,
                weight=bone.weight,
            )
        )
    return Skeleton(bones, "parent")


def positions_by_mujoco(path, robot):
    """Return a function of a configuration: the positions of all bodies relative to the root's, by MuJoCo."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    address = [model.joint(name).qposadr[0] for name in robot.dof_names]
    bodies = [model.body(name).id for name in robot.joint_names]
    root = model.body_parentid[bodies[0]]

    def place(pose):
        data.qpos[address] = pose
        mujoco.mj_kinematics(model, data)
        return (data.xpos[bodies] - data.xpos[root]) @ data.xmat[root].reshape(3, 3)

    return place


def positions_by_pinocchio(robot):
    """Return a function of a configuration: the positions of all bodies, by pinocchio."""
    import pinocchio

    model = pinocchio.Model()
    of_joint, frames = {None: (0, pinocchio.SE3.Identity())}, []
    for bone, rest in zip(robot.bones, robot.rest_rotations, strict=True):
        parent, placement = of_joint[bone.parent]
        here = placement * pinocchio.SE3(rest.copy(), np.array(bone.offset))
        if bone.dofs:
            joint = pinocchio.JointModelRevoluteUnaligned(np.array(bone.axis))
            of_joint[bone.name] = model.addJoint(parent, joint, here, bone.dof_name), pinocchio.SE3.Identity()
        else:
            of_joint[bone.name] = parent, here
        joint, where = of_joint[bone.name]
        frame = pinocchio.Frame(bone.name, joint, 0, where, pinocchio.FrameType.OP_FRAME)
        frames.append(model.addFrame(frame))
    data = model.createData()
    order = np.argsort([model.joints[model.getJointId(name)].idx_q for name in robot.dof_names])

    def place(pose):
        pinocchio.framesForwardKinematics(model, data, pose[order])
        return np.array([data.oMf[frame].translation for frame in frames])

    return place


def lengths(X, place, weights):
    """Return the lengths of the straight lines between all pairs, each pose along them placed."""
    D = np.zeros((len(X), len(X)))
    for i in range(len(X)):
        for j in range(i):
            line = [place(X[i] + t * (X[j] - X[i])) for t in np.linspace(0, 1, N_STEPS + 1)]
            D[i, j] = D[j, i] = np.sqrt((weights[:, None] * np.diff(line, axis=0) ** 2).sum(axis=(1, 2))).sum()
    return D


def main():
    arguments = parser(__doc__)
    arguments.add_argument("--robot", help="an MJCF file with hinges; default: one of proportions of nobody")
    options = arguments.parse_args()
    options.robot = options.robot or str(stand_in.write_robot(mkdtemp()))
    print_machine()
    robot, n = load_robot(options.robot), N_QUICK if options.quick else N
    prototype = on_turned_frames(robot)
    rng = np.random.default_rng(0)
    low, high = np.clip(robot.limits if robot.limits is not None else np.full((robot.n_dofs, 2), [-3, 3]), -3, 3).T
    X = rng.uniform(low, high, size=(2 * n, robot.n_dofs))
    contestants = {
        "skpose": lambda: pose_distances(X[:n], X[n:], skeleton=robot, metric=LINE, n_jobs=1),
        "skpose, frames of a prototype": lambda: pose_distances(
            X[:n], X[n:], skeleton=prototype, metric=LINE, n_jobs=1
        ),
        "skpose, two threads": lambda: pose_distances(X[:n], X[n:], skeleton=robot, metric=LINE, n_jobs=2),
    }
    pairs = dict.fromkeys(contestants, n * n)
    if options.folder:
        people = load_cmu(options.folder)
        person, poses = people.skeleton, people.poses(12.0)[0]
        Y = poses[rng.permutation(len(poses))[: 2 * n]]
        half = len(Y) // 2
        name = f"skpose, a person of {person.n_dofs} dofs"
        contestants[name] = lambda: pose_distances(Y[:half], Y[half:], skeleton=person, metric=LINE, n_jobs=1)
        pairs[name] = half * (len(Y) - half)
    few = X[:N_OTHERS]
    exact = pose_distances(few, skeleton=robot, metric=LINE)
    others = {"numpy and MuJoCo": positions_by_mujoco(options.robot, robot)}
    try:
        others["pinocchio"] = positions_by_pinocchio(robot)
    except ImportError as error:
        print(f"pinocchio left out: {error}")
    for name, place in others.items():
        contestants[name] = lambda place=place: lengths(few, place, robot.weights)
        pairs[name] = N_OTHERS * (N_OTHERS - 1) // 2
    expected = pose_distances(X[:n], X[n:], skeleton=robot, metric=LINE)
    again = pose_distances(X[:n], X[n:], skeleton=prototype, metric=LINE)
    differences = {"skpose, frames of a prototype": np.abs(again - expected).max() / expected.max()}
    for name, place in others.items():
        differences[name] = np.abs(lengths(few, place, robot.weights) - exact).max() / exact.max()
    seconds = medians(contestants)
    print(f"\n{robot.n_dofs} dofs, {robot.n_joints} bodies, {N_STEPS} steps\n")
    print("| | pairs a second | skpose is faster | largest difference, relative |\n|---|--:|--:|--:|")
    for name, taken in seconds.items():
        speed, ratio = pairs[name] / taken, seconds["skpose"] / pairs["skpose"] * pairs[name] / taken
        gap = f"{differences[name]:.0e}" if name in differences else ""
        print(f"| {name} | {speed:,.0f} | {1 / ratio:,.2f} × | {gap} |")


if __name__ == "__main__":
    main()
