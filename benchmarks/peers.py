"""The spatial distance and forward kinematics with other people's tools.

These are numpy, JAX, torch, pinocchio, MuJoCo and scikit-learn.

    pip install "skpose[bench]"
    python benchmarks/peers.py [FOLDER OF CMU FILES] [--quick]

All contestants take turns; every answer is checked against the scalar kernel's in the same run. JAX, torch and numpy
run one source (`column_kinematics`), a column of numbers per matrix element, which is several times faster in JAX than
products of 3 x 3 matrices under `vmap`. Each may use all cores. Tools that are not installed are left out.
"""

import importlib
import itertools
import os
from typing import NamedTuple

import common
import numpy as np
import scalar
from robotics import Bodies
from sklearn.metrics import pairwise_distances

from skpose import forward_kinematics, pose_distances, pose_metric
from skpose.metrics import Spatial

N_STEPS = 10
TIMES = np.linspace(0, 1, N_STEPS + 1)[:, None]
RNG = np.random.default_rng(0)


class Size(NamedTuple):
    n_poses: int  # of X and of Y
    n_copies: int  # of X, for the forward kinematics
    n_rows: int  # of X, for the scalar kernel
    n_few: int  # pairs, for a loop over pairs
    repeats: int


FULL = Size(2000, 10, 100, 20, common.REPEATS)
QUICK = Size(60, 2, 20, 2, 1)


class Contestant(NamedTuple):
    n_rows: int  # of X
    n_columns: int  # poses of Y
    lengths: object  # distances from some rows of X
    tolerance: float = 1e-10


def installed(name):
    """Return a module, or None where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"{name} is not installed: it is left out")
        return None


def column_kinematics(theta, skeleton, xp):
    """Joint positions (3, ...) of every joint, as a list, for angles (n_dofs, ...)."""
    C, S = xp.cos(theta), xp.sin(theta)
    zero = 0.0 * C[0]
    frames, ends, d = [], [], 0
    for bone, parent, rest, offset in zip(
        skeleton.bones, skeleton.parents, skeleton.rest_rotations, skeleton.offsets, strict=True
    ):
        before = [[zero + (i == k) for k in range(3)] for i in range(3)] if parent < 0 else frames[parent]
        if np.allclose(rest, np.eye(3), atol=1e-15):
            H = [list(row) for row in before]
        else:
            H = [[sum(row[m] * float(rest[m, k]) for m in range(3)) for k in range(3)] for row in before]
        for i in reversed(range(len(bone.dofs))):
            a = "xyz".index(bone.dofs[i])
            u, v = (a + 1) % 3, (a + 2) % 3
            c, s = C[d + i], S[d + i]
            for row in H:
                row[u], row[v] = c * row[u] + s * row[v], c * row[v] - s * row[u]
        d += len(bone.dofs)
        reach = xp.stack([sum(row[m] * float(offset[m]) for m in range(3)) for row in H])
        frames.append(H)
        ends.append(reach if parent < 0 else ends[parent] + reach)
    return ends


def column_lengths(x, Y, t, skeleton, xp):
    """Spatial distances from one pose x (n_dofs, 1, 1) to others Y (n_dofs, 1, n), at the times t (n_samples, 1)."""
    ends = column_kinematics(x + t * (Y - x), skeleton, xp)
    return xp.sqrt(sum(((P[:, 1:] - P[:, :-1]) ** 2).sum(0) for P in ends)).sum(0)


class Pinocchio:
    """The skeleton as one revolute joint per dof, as a URDF file has it."""

    def __init__(self, pinocchio, skeleton):
        self.pinocchio = pinocchio
        axes = (pinocchio.JointModelRX, pinocchio.JointModelRY, pinocchio.JointModelRZ)
        self.model = pinocchio.Model()
        self.ends, self.order, d = [], [], 0  # (joint, bone's end and orientation in its axes); dof of each joint
        for bone, parent, rest, offset in zip(
            skeleton.bones, skeleton.parents, skeleton.rest_rotations, skeleton.offsets, strict=True
        ):
            joint, end, rotation = (0, np.zeros(3), np.eye(3)) if parent < 0 else self.ends[parent]
            rotation = rotation @ rest
            for i in reversed(range(len(bone.dofs))):
                axis = axes["xyz".index(bone.dofs[i])]()
                placement = pinocchio.SE3(rotation, end)
                joint = self.model.addJoint(joint, axis, placement, f"{bone.name}_{bone.dofs[i]}")
                self.order.append(d + i)
                end, rotation = np.zeros(3), np.eye(3)
            d += len(bone.dofs)
            self.ends.append((joint, end + rotation @ offset, rotation))
        self.data = self.model.createData()

    def run(self, poses):
        for q in poses:
            self.pinocchio.forwardKinematics(self.model, self.data, q)

    def positions(self, q):
        self.pinocchio.forwardKinematics(self.model, self.data, q)
        return np.array([self.data.oMi[joint].act(end) for joint, end, _ in self.ends])

    def lengths(self, x, Y):
        """Spatial distances from one pose to others."""
        out = []
        for y in Y:
            F = [self.positions(x + n / N_STEPS * (y - x)) for n in range(N_STEPS + 1)]
            out.append(sum(np.linalg.norm(b - a) for a, b in itertools.pairwise(F)))
        return np.array(out)


class MuJoCo:
    """The skeleton as `robotics.Bodies`, one pose at a time."""

    def __init__(self, mujoco, skeleton):
        self.mujoco, self.bodies = mujoco, Bodies(skeleton, mujoco)
        self.data = mujoco.MjData(self.bodies.model)
        self.order, self.free = self.bodies.columns, mujoco.MjData(self.bodies.model).qpos[:7].copy()

    def run(self, poses):
        for q in poses:
            self.data.qpos[7:] = q
            self.mujoco.mj_kinematics(self.bodies.model, self.data)

    def positions(self, q):
        self.data.qpos[:7] = self.free
        self.run([q])
        return self.data.site_xpos[self.bodies.sites]


def kinematics(X, skeleton, tree, jax, robots, size):
    """Print times of the forward kinematics."""
    many = np.tile(X, (size.n_copies, 1))
    expected = scalar.forward_kinematics(many, tree)
    np.testing.assert_allclose(forward_kinematics(many, skeleton), expected, atol=1e-12)
    contestants = {
        "skpose, one core": lambda: forward_kinematics(many, skeleton),
        "scalar kernel, all cores": lambda: scalar.forward_kinematics(many, tree),
    }
    if jax:
        place = jax.jit(
            lambda theta: jax.numpy.stack(column_kinematics(theta.T, skeleton, jax.numpy)).transpose(2, 0, 1)
        )
        jax_many = jax.numpy.asarray(many)
        np.testing.assert_allclose(np.asarray(place(jax_many)), expected, atol=1e-12)
        contestants["JAX, jit"] = lambda: place(jax_many).block_until_ready()
    for name, robot in robots.items():
        np.testing.assert_allclose(robot.positions(many[7][robot.order]), expected[7], atol=1e-12)
        ordered = np.ascontiguousarray(many[:, robot.order])
        contestants[f"{name}, a loop"] = lambda robot=robot, ordered=ordered: robot.run(ordered)
    seconds = common.medians(contestants, size.repeats)
    print(f"forward kinematics of {len(many):,} poses")
    for name, value in seconds.items():
        print(f"  {name:<28}{1e3 * value:>10.1f} ms{value / seconds['skpose, one core']:>10.2f}")


def contestants_of(X, Y, skeleton, tree, jax, torch, pin, size):
    """Return what computes spatial distances, by name."""
    columns, single = np.ascontiguousarray(Y.T[:, None]), (X.astype(np.float32), Y.astype(np.float32))
    few = Y[: size.n_few]
    literal = Spatial(wrap=False)
    f = pose_metric(skeleton, metric=literal)

    def by_skpose(A, B):
        return pose_distances(A, B, skeleton=skeleton, metric=literal, n_jobs=-1)

    def by_numpy(A, columns):
        return [column_lengths(a[:, None, None], columns, TIMES, skeleton, np) for a in A]

    def by_pairs(A):
        return [[column_lengths(a[:, None, None], y[:, None, None], TIMES, skeleton, np)[0] for y in few] for a in A]

    found = {
        "scalar kernel, all cores": Contestant(size.n_rows, len(Y), lambda A: scalar.spatial(A, Y, tree, N_STEPS)),
        "numpy, a loop over pairs": Contestant(1, len(few), by_pairs),
    }
    if pin:
        n = min(50, len(Y))
        found["pinocchio, a call per sample"] = Contestant(
            1, n, lambda A: [pin.lengths(a[pin.order], Y[:n, pin.order]) for a in A]
        )
    found["numpy, batched"] = Contestant(1, len(Y), lambda A: by_numpy(A, columns))
    if jax:
        row = jax.jit(lambda x, Y, t: column_lengths(x, Y, t, skeleton, jax.numpy))
        jax_Y, jax_t = jax.numpy.asarray(columns), jax.numpy.asarray(TIMES)
        found["JAX, jit"] = Contestant(
            5, len(Y), lambda A: [np.asarray(row(jax.numpy.asarray(a)[:, None, None], jax_Y, jax_t)) for a in A]
        )
    if torch:
        torch_Y, torch_t = torch.from_numpy(columns), torch.from_numpy(TIMES)

        def by_torch(A):
            rows = (torch.from_numpy(a)[:, None, None] for a in A)
            return [column_lengths(a, torch_Y, torch_t, skeleton, torch).numpy() for a in rows]

        found["torch, batched"] = Contestant(1, len(Y), by_torch)
    found["scikit-learn, pose_metric"] = Contestant(
        20, len(Y), lambda A: pairwise_distances(A, Y, metric=f, n_jobs=os.cpu_count())
    )
    found["skpose"] = Contestant(len(X), len(Y), lambda A: by_skpose(A, Y))
    found["skpose, float32"] = Contestant(len(X), len(Y), lambda A: by_skpose(*single), tolerance=2e-5)
    return found


def spatial(X, Y, tree, contestants, size):
    """Compare the answers, and print pairs per second."""
    expected = scalar.spatial(X[: size.n_rows], Y, tree, N_STEPS)
    for name, (n_rows, n_columns, lengths, tolerance) in contestants.items():
        n = min(n_rows, size.n_rows)
        np.testing.assert_allclose(
            np.asarray(lengths(X[:n_rows]))[:n], expected[:n, :n_columns], rtol=tolerance, atol=1e-9, err_msg=name
        )
    seconds = common.medians(
        {name: (lambda c=c: c.lengths(X[: c.n_rows])) for name, c in contestants.items()}, size.repeats
    )
    rate = {name: c.n_rows * c.n_columns / seconds[name] for name, c in contestants.items()}
    print(f"\nspatial distance, n_steps = {N_STEPS}")
    for name, value in rate.items():
        print(f"  {name:<32}{value:>14,.0f} pairs/s{value / rate['scalar kernel, all cores']:>10.3f}")


def main():
    options = common.start(__doc__)
    size = QUICK if options.quick else FULL
    jax, torch, pinocchio, mujoco = (installed(name) for name in ("jax", "torch", "pinocchio", "mujoco"))
    if jax:
        jax.config.update("jax_enable_x64", True)
    dataset = common.motions(options.folder)
    skeleton, (poses, _) = dataset.skeleton, dataset.poses()
    poses = poses[RNG.choice(len(poses), 2 * size.n_poses, replace=False)]
    X, Y = np.ascontiguousarray(poses[: size.n_poses]), np.ascontiguousarray(poses[size.n_poses :])
    tree, pin = scalar.tree_of(skeleton), Pinocchio(pinocchio, skeleton) if pinocchio else None
    robots = {"pinocchio": pin} if pin else {}
    if mujoco:
        robots["MuJoCo"] = MuJoCo(mujoco, skeleton)
    versions = ", ".join(f"{tool.__name__} {tool.__version__}" for tool in (jax, torch, pinocchio, mujoco) if tool)
    print(f"{dataset}\n{versions}\n")
    kinematics(X, skeleton, tree, jax, robots, size)
    spatial(X, Y, tree, contestants_of(X, Y, skeleton, tree, jax, torch, pin, size), size)


if __name__ == "__main__":
    main()
