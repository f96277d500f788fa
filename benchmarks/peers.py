"""The spatial distance and forward kinematics with other people's tools: numpy, JAX, torch, pinocchio, scikit-learn.

    pip install "skpose[bench]"
    python benchmarks/peers.py [FOLDER OF CMU FILES]

All contestants take turns; every answer is checked against the scalar kernel's in the same run. JAX, torch and numpy
run one source (`column_kinematics`), a column of numbers per matrix element, which is several times faster in JAX than
products of 3 x 3 matrices under `vmap`. Each may use all cores.
"""

import itertools
import os
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pinocchio
import scalar
import torch
from sklearn.metrics import pairwise_distances
from timing import medians

from skpose import forward_kinematics, pose_distances, pose_metric
from skpose.datasets import load_cmu, make_gait

N_STEPS = 10
N_Y, N_PLACED = 2000, 20_000
RNG = np.random.default_rng(0)


def column_kinematics(theta, skeleton, xp):
    """Joint positions (3, ...) of every joint, as a list, for angles (n_dofs, ...)."""
    C, S = xp.cos(theta), xp.sin(theta)
    zero = 0.0 * C[0]
    frames, places, d = [], [], 0
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
        places.append(reach if parent < 0 else places[parent] + reach)
    return places


def column_lengths(x, Y, t, skeleton, xp):
    """Spatial distances from one pose x (n_dofs, 1, 1) to others Y (n_dofs, 1, n), at the times t (n_samples, 1)."""
    places = column_kinematics(x + t * (Y - x), skeleton, xp)
    return xp.sqrt(sum(((P[:, 1:] - P[:, :-1]) ** 2).sum(0) for P in places)).sum(0)


class Pinocchio:
    """The skeleton as one revolute joint per dof, as a URDF file would have it."""

    AXES = (pinocchio.JointModelRX, pinocchio.JointModelRY, pinocchio.JointModelRZ)

    def __init__(self, skeleton):
        self.model = pinocchio.Model()
        self.ends, self.order, d = [], [], 0  # (joint, bone's end in its axes); which dof each joint is
        for bone, parent, rest, offset in zip(
            skeleton.bones, skeleton.parents, skeleton.rest_rotations, skeleton.offsets, strict=True
        ):
            joint, end, turn = (0, np.zeros(3), np.eye(3)) if parent < 0 else self.ends[parent]
            turn = turn @ rest
            for i in reversed(range(len(bone.dofs))):
                axis = self.AXES["xyz".index(bone.dofs[i])]()
                placement = pinocchio.SE3(turn, end)
                joint = self.model.addJoint(joint, axis, placement, f"{bone.name}_{bone.dofs[i]}")
                self.order.append(d + i)
                end, turn = np.zeros(3), np.eye(3)
            d += len(bone.dofs)
            self.ends.append((joint, end + turn @ offset, turn))
        self.data = self.model.createData()

    def run(self, poses):
        for q in poses:
            pinocchio.forwardKinematics(self.model, self.data, q)

    def positions(self, q):
        pinocchio.forwardKinematics(self.model, self.data, q)
        return np.array([self.data.oMi[joint].act(end) for joint, end, _ in self.ends])

    def lengths(self, x, Y):
        out = []
        for y in Y:
            F = [self.positions(x + n / N_STEPS * (y - x)) for n in range(N_STEPS + 1)]
            out.append(sum(np.linalg.norm(b - a) for a, b in itertools.pairwise(F)))
        return np.array(out)


def main():
    jax.config.update("jax_enable_x64", True)
    dataset = load_cmu(sys.argv[1]) if len(sys.argv) > 1 else make_gait(10, 10, random_state=0)
    skeleton, (poses, _) = dataset.skeleton, dataset.poses()
    poses = poses[RNG.choice(len(poses), 2 * N_Y, replace=False)]
    X, Y = np.ascontiguousarray(poses[:N_Y]), np.ascontiguousarray(poses[N_Y:])
    tree, body = scalar.tree_of(skeleton), Pinocchio(skeleton)
    print(f"{dataset}\n{os.cpu_count()} cores, jax {jax.__version__}, torch {torch.__version__}", end=", ")
    print(f"pinocchio {pinocchio.__version__}\n")

    many = np.tile(X, (N_PLACED // N_Y, 1))
    place = jax.jit(lambda theta: jnp.stack(column_kinematics(theta.T, skeleton, jnp)).transpose(2, 0, 1))
    jax_many = jnp.asarray(many)
    expected = scalar.forward_kinematics(many, tree)
    np.testing.assert_allclose(forward_kinematics(many, skeleton), expected, atol=1e-12)
    np.testing.assert_allclose(np.asarray(place(jax_many)), expected, atol=1e-12)
    np.testing.assert_allclose(body.positions(many[7][body.order]), expected[7], atol=1e-12)
    ordered = np.ascontiguousarray(many[:, body.order])
    seconds = medians(
        {
            "skpose, one core": lambda: forward_kinematics(many, skeleton),
            "scalar kernel, all cores": lambda: scalar.forward_kinematics(many, tree),
            "JAX, jit": lambda: place(jax_many).block_until_ready(),
            "pinocchio, a loop": lambda: body.run(ordered),
        }
    )
    print(f"forward kinematics of {N_PLACED:,} poses")
    for name, value in seconds.items():
        print(f"  {name:<28}{1e3 * value:>10.1f} ms{value / seconds['skpose, one core']:>10.2f}")

    times = np.linspace(0, 1, N_STEPS + 1)[:, None]
    row = jax.jit(lambda x, Y, t: column_lengths(x, Y, t, skeleton, jnp))
    jax_Y, jax_t = jnp.asarray(Y.T[:, None]), jnp.asarray(times)
    torch_Y, torch_t = torch.from_numpy(np.ascontiguousarray(Y.T[:, None])), torch.from_numpy(times)
    f = pose_metric(skeleton, metric="spatial", wrap=False)
    single = X.astype(np.float32), Y.astype(np.float32)

    def with_torch(x):
        return column_lengths(torch.from_numpy(x)[:, None, None], torch_Y, torch_t, skeleton, torch).numpy()

    def distances(A, B):
        return pose_distances(A, B, skeleton=skeleton, wrap=False, n_jobs=-1)

    # name: rows of X, columns of Y, distances of these
    contestants = {
        "scalar kernel, all cores": (100, N_Y, lambda A: scalar.spatial(A, Y, tree, N_STEPS)),
        "numpy, a loop over pairs": (
            1,
            20,
            lambda A: [
                [column_lengths(a[:, None, None], y[:, None, None], times, skeleton, np)[0] for y in Y[:20]] for a in A
            ],
        ),
        "pinocchio, a call per sample": (1, 50, lambda A: [body.lengths(a[body.order], Y[:50, body.order]) for a in A]),
        "numpy, batched": (
            1,
            N_Y,
            lambda A: [column_lengths(a[:, None, None], Y.T[:, None], times, skeleton, np) for a in A],
        ),
        "JAX, jit": (5, N_Y, lambda A: [np.asarray(row(jnp.asarray(a)[:, None, None], jax_Y, jax_t)) for a in A]),
        "torch, batched": (1, N_Y, lambda A: [with_torch(a) for a in A]),
        "scikit-learn, pose_metric": (
            20,
            N_Y,
            lambda A: pairwise_distances(A, Y, metric=f, n_jobs=os.cpu_count()),
        ),
        "skpose": (N_Y, N_Y, lambda A: distances(A, Y)),
        "skpose, float32": (N_Y, N_Y, lambda A: distances(single[0], single[1])),
    }
    right = scalar.spatial(X[:100], Y, tree, N_STEPS)
    for name, (n_rows, n_columns, lengths) in contestants.items():
        tolerance = 2e-5 if "float32" in name else 1e-10
        n = min(n_rows, 100)
        np.testing.assert_allclose(
            np.asarray(lengths(X[:n_rows]))[:n], right[:n, :n_columns], rtol=tolerance, atol=1e-9
        )
    seconds = medians({name: (lambda n=n, g=g: g(X[:n])) for name, (n, _, g) in contestants.items()})
    rate = {name: n * m / seconds[name] for name, (n, m, _) in contestants.items()}
    print("\nspatial distance, n_steps = 10")
    for name, value in rate.items():
        print(f"  {name:<32}{value:>14,.0f} pairs/s{value / rate['scalar kernel, all cores']:>10.3f}")


if __name__ == "__main__":
    main()
