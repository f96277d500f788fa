"""Robots: forward kinematics and Jacobians against MuJoCo's.

    pip install "skpose[bench]"
    python benchmarks/robots.py --robots FOLDER [--quick]

The folder has robots as MJCF or URDF files. Of each the bodies of random configurations, uniform within the limits of
the joints, and within half a turn, or 1 m, where a joint has none, are compared with `mj_kinematics`, and their
derivatives with `mj_jacBody`: the largest differences, relative to the root. Without a folder, an arm with axes of any
direction.
"""

import io
from pathlib import Path

import common
import mujoco
import numpy as np

from skpose import forward_kinematics
from skpose.kinematics import position_jacobian
from skpose.robots import load_robot

N_CONFIGURATIONS, CHUNK = 10_000, 500
WITHIN = 1e-13  # m, and m/rad
ARM = """<mujoco model="arm"><worldbody><body name="shoulder" pos="0.1 0 1" euler="10 20 30">
<joint name="a" axis="0 1 0" range="-90 90"/><joint name="b" axis="1 1 0" ref="20"/>
<body name="elbow" pos="0.3 0 0"><joint name="c" axis="0 -0.6 0.8" pos="0.01 0 0.02"/>
<body name="hand" pos="0.2 0 0.1" quat="1 2 3 4"><joint name="d" axis="1 0 0"/>
<body name="finger" pos="0.1 0 0"/></body></body></body></worldbody></mujoco>"""


def robots(folder):
    """Return the skeleton and the model of each robot by its name."""
    if folder is None:
        return {"arm": (load_robot(io.StringIO(ARM)), model_of(ARM, mujoco.MjSpec.from_string))}
    paths = sorted(path for path in Path(folder).iterdir() if path.suffix in (".xml", ".urdf"))
    return {path.stem: (load_robot(path), model_of(str(path), mujoco.MjSpec.from_file)) for path in paths}


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


def configurations(skeleton, n, rng):
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
    """Return the largest differences of positions, m, and of Jacobians, m/rad."""
    reference, rng = Reference(skeleton, model), np.random.default_rng(0)
    positions = jacobians = 0.0
    for start in range(0, n, CHUNK):
        X = configurations(skeleton, min(CHUNK, n - start), rng)
        P = forward_kinematics(X, skeleton)[:, reference.rows]
        J = position_jacobian(X, skeleton).reshape(len(X), skeleton.n_joints, 3, -1)[:, reference.rows]
        for pose, p, j in zip(X, P, J, strict=True):
            reference.place(pose)
            positions = max(positions, np.abs(reference.positions() - p).max())
            jacobians = max(jacobians, np.abs(reference.jacobian() - j).max())
    return positions, jacobians


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--robots", help="folder of MJCF and URDF files; default: one small arm")
    options = arguments.parse_args()
    common.print_machine()
    n = 100 if options.quick else N_CONFIGURATIONS
    found = robots(options.robots)
    print(f"\nMuJoCo {mujoco.__version__}, {n:,} random configurations of each robot, largest differences:\n")
    print("| robot | links | columns | positions, m | Jacobian, m/rad |\n|---|---|---|---|---|")
    for name, (skeleton, model) in found.items():
        positions, jacobians = differences(skeleton, model, n)
        print(f"| {name} | {model.nbody - 1} | {skeleton.n_dofs} | {positions:.1e} | {jacobians:.1e} |", flush=True)
        assert max(positions, jacobians) <= WITHIN, f"{name}: {positions}, {jacobians}"


if __name__ == "__main__":
    main()
