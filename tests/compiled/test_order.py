"""The supernodes into which the solver of geodesics divides a skeleton."""

import numpy as np
import pytest
from conftest import MIXED, random_tree
from entries import from_python

from skpose import Bone, Skeleton
from skpose._compiled.path import order as orders
from skpose.datasets import humanoid
from skpose.kinematics._tree import tree_of

order_of = from_python(orders.order_of)
N_FREE = orders.N_FREE, orders.N_FREE_REFINED


def hands(n_fingers=5):
    """A trunk with two arms, each with fingers of three joints."""
    bones = [Bone("spine", None, [0, 0.5, 0], "XYZ"), Bone("neck", "spine", [0, 0.2, 0], "XYZ")]
    for side in (-1, 1):
        parent = "spine"
        for name in ("shoulder", "elbow", "wrist"):
            bones.append(Bone(f"{name}{side}", parent, [0.3 * side, 0, 0], "XYZ"))
            parent = bones[-1].name
        for finger in range(n_fingers):
            carrier = parent
            for joint in range(3):
                bones.append(Bone(f"finger{side}_{finger}_{joint}", carrier, [0.03 * side, 0, 0.01 * finger], "XYZ"))
                carrier = bones[-1].name
    return Skeleton(bones)


SKELETONS = {
    "hands": hands(),
    "many fingers": hands(20),
    "humanoid": humanoid(),
    "chain": Skeleton.chain(30),
    "face": Skeleton(
        [Bone("head", None, [0, 1, 0], "XYZ"), *(Bone(f"{i}", "head", [0, 1, i], "X") for i in range(60))]
    ),
    "root alone": None,
} | {f"random {seed}": random_tree(seed, n=60, kinds=MIXED, offset_frame="parent") for seed in range(5)}


@pytest.fixture(params=SKELETONS, scope="module")
def tree(request):
    return tree_of(SKELETONS[request.param])


@pytest.fixture(scope="module")
def order(tree):
    return order_of(tree)


def coupled(tree):
    """Return which dofs move a joint in common: where one is an ancestor of the other."""
    pairs = np.zeros((len(tree.column), len(tree.column)), bool)
    for f in range(1, len(tree.frame_parent)):
        for first, end in tree.dof_ranges[tree.first_dof_range[f] : tree.first_dof_range[f + 1]]:
            pairs[tree.first_dof[f] : tree.end_dof[f], first:end] = True
    return pairs | pairs.T


def test_every_dof_has_one_place(order):
    for kind in range(2):
        first, end = order.first_supernode[kind : kind + 2]
        places = [tuple(place) for place in order.indices[kind]]
        expected = [(k, i) for k in range(first, end) for i in range(order.supernodes[k, 2])]
        assert sorted(places) == expected
        for d, (k, _) in enumerate(places):
            assert order.supernodes[k, 0] <= d < order.supernodes[k, 1]


def test_pieces_couple_only_through_ancestors(tree, order):
    pairs = coupled(tree)
    for kind in range(2):
        supernode = order.indices[kind, :, 0]
        for d, e in zip(*np.nonzero(pairs & (supernode[:, None] != supernode)), strict=True):
            limb, trunk = (d, e) if order.supernodes[supernode[d], 3] > 0 else (e, d)
            row = order.supernodes[supernode[limb]]
            assert supernode[trunk] == row[4]
            assert order.supernodes[supernode[trunk], 5] == 1
            assert trunk in order.ancestors[supernode[limb], : row[3]]


def test_limbs_follow_one_another_before_their_trunk(order):
    assert order.first_supernode[0] == 0
    assert order.first_supernode[2] == len(order.supernodes)
    for k, (*_, n_ancestors, trunk, is_dense) in enumerate(order.supernodes):
        assert trunk > k if n_ancestors else trunk == k
        assert is_dense == (n_ancestors == 0 and k in order.supernodes[:k, 4])


def multiplications(order, kind, n_free):
    """Count those of the factors of either kind, row by row of matrices whose rows are padded to eight numbers."""
    total = 0.0
    for k in range(order.first_supernode[kind], order.first_supernode[kind + 1]):
        _, _, n, n_ancestors, _, is_dense = order.supernodes[k]
        n_blocks, m = (1, 8 * -(-n * n_free // 8)) if is_dense else (n_free, 8 * -(-n // 8))
        for i in range(n_blocks):
            columns = n_ancestors * (i + 1)  # that are not zero in the row of pose i, about
            total += sum((q if i == 0 else m + q) * (2 * m - q + columns) for q in range(m)) / (2 if is_dense else 1)
            total += m * columns**2 / 2
    return total


@pytest.mark.parametrize("name", ["hands", "many fingers"])
def test_limbs_are_eliminated_first_where_that_takes_fewer_multiplications(name):
    order = order_of(tree_of(SKELETONS[name]))
    assert order.first_supernode[2] - order.first_supernode[1] > order.first_supernode[1]
    assert order.most_poses[0] == N_FREE[-1]
    for n_free in N_FREE:
        assert multiplications(order, 1, n_free) < orders.WORTH * multiplications(order, 0, n_free)


@pytest.mark.parametrize("name", ["humanoid", "chain", "face", "root alone"])
def test_other_skeletons_have_no_limbs(name):
    order = order_of(tree_of(SKELETONS[name]))
    assert order.most_poses[0] == 0
    first, second = (order.supernodes[order.first_supernode[i] : order.first_supernode[i + 1]] for i in range(2))
    np.testing.assert_array_equal(first[:, [0, 1, 2, 3, 5]], second[:, [0, 1, 2, 3, 5]])
