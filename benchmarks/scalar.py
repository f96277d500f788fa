"""The distances as one would first write them in numba: one pair at a time, all sines and cosines computed afresh.

Speed is measured against these. Rows are spread over all cores.
"""

import math

import numba
import numpy as np


def tree_of(skeleton):
    """Parent, rest rotation, offset, first dof and axis of every bone, for a skeleton whose dofs are all extrinsic."""
    first = np.cumsum([0] + [len(bone.dofs) for bone in skeleton.bones])
    axis = np.array(["xyz".index(letter) for bone in skeleton.bones for letter in bone.dofs])
    return skeleton.parents.copy(), skeleton.rest_rotations.copy(), skeleton.offsets.copy(), first, axis


@numba.njit(cache=True)
def place(theta, tree, H, P):
    """Orientation H (n, 3, 3) and far end P (n, 3) of every bone."""
    parent, rest, offset, first, axis = tree
    for b in range(parent.shape[0]):
        p = parent[b]
        for i in range(3):
            for j in range(3):
                if p < 0:
                    H[b, i, j] = rest[b, i, j]
                else:
                    H[b, i, j] = H[p, i, 0] * rest[b, 0, j] + H[p, i, 1] * rest[b, 1, j] + H[p, i, 2] * rest[b, 2, j]
        for d in range(first[b + 1] - 1, first[b] - 1, -1):
            c, s = math.cos(theta[d]), math.sin(theta[d])
            j, k = (axis[d] + 1) % 3, (axis[d] + 2) % 3
            for i in range(3):
                u, v = H[b, i, j], H[b, i, k]
                H[b, i, j], H[b, i, k] = c * u + s * v, c * v - s * u
        for i in range(3):
            x = H[b, i, 0] * offset[b, 0] + H[b, i, 1] * offset[b, 1] + H[b, i, 2] * offset[b, 2]
            P[b, i] = x if p < 0 else P[p, i] + x


@numba.njit(parallel=True, cache=True)
def forward_kinematics(X, tree):
    """Joint positions (n_poses, n, 3)."""
    n = tree[0].shape[0]
    out = np.empty((X.shape[0], n, 3))
    for a in numba.prange(X.shape[0]):
        place(X[a], tree, np.empty((n, 3, 3)), out[a])
    return out


@numba.njit(parallel=True, cache=True)
def angle(X, Y, tree):
    D = np.empty((X.shape[0], Y.shape[0]))
    for a in numba.prange(X.shape[0]):
        for b in range(Y.shape[0]):
            square = 0.0
            for d in range(X.shape[1]):
                square += (X[a, d] - Y[b, d]) ** 2
            D[a, b] = math.sqrt(square)
    return D


@numba.njit(parallel=True, cache=True)
def position(X, Y, tree):
    n = tree[0].shape[0]
    D = np.empty((X.shape[0], Y.shape[0]))
    for a in numba.prange(X.shape[0]):
        H, P, Q = np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((n, 3))
        place(X[a], tree, H, P)
        for b in range(Y.shape[0]):
            place(Y[b], tree, H, Q)
            square = 0.0
            for k in range(n):
                for i in range(3):
                    square += (P[k, i] - Q[k, i]) ** 2
            D[a, b] = math.sqrt(square)
    return D


@numba.njit(parallel=True, cache=True)
def rotation(X, Y, tree):
    n, offset = tree[0].shape[0], tree[2]
    D = np.empty((X.shape[0], Y.shape[0]))
    for a in numba.prange(X.shape[0]):
        G, H, P = np.empty((n, 3, 3)), np.empty((n, 3, 3)), np.empty((n, 3))
        place(X[a], tree, G, P)
        for b in range(Y.shape[0]):
            place(Y[b], tree, H, P)
            total = 0.0
            for k in range(n):
                trace, square = 0.0, 0.0
                for i in range(3):
                    square += offset[k, i] ** 2
                    for j in range(3):
                        trace += G[k, i, j] * H[k, i, j]
                total += square * math.acos(min(1.0, max(-1.0, (trace - 1.0) / 2.0))) ** 2
            D[a, b] = math.sqrt(total)
    return D


@numba.njit(parallel=True, cache=True)
def spatial(X, Y, tree, n_steps=10):
    n = tree[0].shape[0]
    D = np.empty((X.shape[0], Y.shape[0]))
    for a in numba.prange(X.shape[0]):
        H, P, Q, theta = np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty(X.shape[1])
        for b in range(Y.shape[0]):
            length = 0.0
            for step in range(n_steps + 1):
                t = step / n_steps
                for d in range(X.shape[1]):
                    theta[d] = X[a, d] + t * (Y[b, d] - X[a, d])
                place(theta, tree, H, P)
                square = 0.0
                for k in range(n):
                    for i in range(3):
                        square += (P[k, i] - Q[k, i]) ** 2
                        Q[k, i] = P[k, i]
                if step > 0:
                    length += math.sqrt(square)
            D[a, b] = length
    return D
