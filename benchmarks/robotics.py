"""Inverse kinematics by a robotics solver: mink with MuJoCo. A free joint at the root, a hinge for each dof.

mink's usual loop: one task for each joint, `solve_ik` for a step, until all joints are within `TOLERANCE`.
"""

import numpy as np
from least_squares import N_ROOT
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics

TOLERANCE, MAX_ITER = 1e-6, 100  # m, steps
# Twists of the ends of limbs move no joint: without the second damping steps do not settle. Of eighteen settings on CMU
# frames these two are among the fastest, and converge.
LM_DAMPING, DAMPING = 1e-3, 1e-6  # the first times the square of the error


class Bodies:
    """The skeleton as a MuJoCo model: a free joint at the root, a hinge for each dof, a site where each bone ends."""

    def __init__(self, skeleton, mujoco):
        spec = mujoco.MjSpec()
        root = spec.worldbody.add_body(name="root")
        root.add_freejoint()
        solid = {"mass": 1.0, "inertia": np.ones(3), "explicitinertial": True}
        for name, value in solid.items():
            setattr(root, name, value)
        ends, dof = [], 0  # (body, position of the joint, rotation of its axes) of each joint
        columns = {}  # of the pose, by the names of the hinges
        for i, bone in enumerate(skeleton.bones):
            parent, end, rotation = (
                ends[skeleton.parents[i]] if skeleton.parents[i] >= 0 else (root, np.zeros(3), np.eye(3))
            )
            turned = rotation @ skeleton.rest_rotations[i]
            body = parent.add_body(
                name=bone.name, pos=end, quat=Rotation.from_matrix(turned).as_quat(scalar_first=True)
            )
            for name, value in solid.items():
                setattr(body, name, value)
            order = range(len(bone.dofs)) if bone.dofs.isupper() else reversed(range(len(bone.dofs)))
            for k in order:
                axis, name = np.eye(3)["xyz".index(bone.dofs[k].lower())], f"{bone.name} {k}"
                body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
                columns[name] = dof + k
            dof += len(bone.dofs)
            offset = skeleton.offsets[i]
            body.add_site(name=f"end of {bone.name}", pos=offset)
            ends.append((body, offset, np.eye(3)))
        self.model = model = spec.compile()
        hinges = [model.joint(i + 1).name for i in range(model.njnt - 1)]  # depth first; the free joint is the first
        self.columns = [columns[name] for name in hinges]
        self.sites = [model.site(f"end of {name}").id for name in skeleton.joint_names]


class Mink:
    """One call finds one frame, and returns the positions of the joints."""

    def __init__(self, skeleton, mink, mujoco):
        self.skeleton, self.mink, self.last = skeleton, mink, None
        bodies = Bodies(skeleton, mujoco)
        self.configuration, self.columns, self.sites = mink.Configuration(bodies.model), bodies.columns, bodies.sites
        self.tasks = [
            mink.FrameTask(f"end of {name}", "site", position_cost=1.0, orientation_cost=0.0, lm_damping=LM_DAMPING)
            for name in skeleton.joint_names
        ]

    def place(self, x):
        quaternion = Rotation.from_rotvec(x[3:N_ROOT]).as_quat(scalar_first=True)
        self.configuration.update(np.concatenate([x[:3], quaternion, x[N_ROOT:][self.columns]]))

    def positions(self):
        return self.configuration.data.site_xpos[self.sites]

    def __call__(self, start, given):
        self.place(start)
        for task, position in zip(self.tasks, given, strict=True):
            task.set_target(self.mink.SE3.from_translation(position))
        for _ in range(MAX_ITER):
            if np.linalg.norm(self.positions() - given, axis=1).max() < TOLERANCE:
                break
            velocity = self.mink.solve_ik(self.configuration, self.tasks, 1.0, "daqp", damping=DAMPING, limits=[])
            self.configuration.integrate_inplace(velocity, 1.0)
        q = self.configuration.q
        self.last = np.empty(len(start))
        self.last[:3], self.last[3:N_ROOT] = q[:3], Rotation.from_quat(q[3:7], scalar_first=True).as_rotvec()
        self.last[N_ROOT + np.array(self.columns)] = q[7:]
        return self.positions().copy()


def solvers(skeleton):
    """Return the solver by its name, after a comparison of its forward kinematics; or why there is none."""
    name = f"mink, MuJoCo, to {TOLERANCE:g} m"
    try:
        import mink
        import mujoco
    except ImportError as error:
        return {name: f"left out, {error}"}
    if skeleton.offset_frame != "own" or any(bone.is_ball for bone in skeleton.bones):
        return {name: "left out: the model is made for hinges whose bones turn with them"}
    solver = Mink(skeleton, mink, mujoco)
    x = np.random.default_rng(0).normal(scale=0.5, size=N_ROOT + skeleton.n_dofs)
    solver.place(x)
    expected = forward_kinematics(x[None, N_ROOT:], skeleton)[0]
    expected = expected @ Rotation.from_rotvec(x[3:N_ROOT]).as_matrix().T + x[:3]
    np.testing.assert_allclose(solver.positions(), expected, atol=1e-9)
    return {name: solver}
