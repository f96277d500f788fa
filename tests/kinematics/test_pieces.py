"""The pieces into which the solver of geodesics divides a skeleton."""

import numpy as np
import pytest
from conftest import MIXED, random_tree

from skpose import Bone, Skeleton
from skpose.datasets import humanoid
from skpose.kinematics import _pieces
from skpose.kinematics._tree import tree_of


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


def coupled(tree):
    """Return which dofs move a joint in common: where one is an ancestor of the other."""
    pairs = np.zeros((len(tree.column), len(tree.column)), bool)
    for f in range(1, len(tree.frame_parent)):
        for first, end in tree.runs[tree.first_run[f] : tree.first_run[f + 1]]:
            pairs[tree.first_dof[f] : tree.end_dof[f], first:end] = True
    return pairs | pairs.T


def test_every_dof_has_one_place(tree):
    for order in range(2):
        first, end = tree.first_piece[order : order + 2]
        places = [tuple(place) for place in tree.places[order]]
        expected = [(k, i) for k in range(first, end) for i in range(tree.pieces[k, 2])]
        assert sorted(places) == expected
        for d, (k, _) in enumerate(places):
            assert tree.pieces[k, 0] <= d < tree.pieces[k, 1]


def test_pieces_couple_only_through_ancestors(tree):
    pairs = coupled(tree)
    for order in range(2):
        piece = tree.places[order, :, 0]
        for d, e in zip(*np.nonzero(pairs & (piece[:, None] != piece)), strict=True):
            limb, trunk = (d, e) if tree.pieces[piece[d], 3] > 0 else (e, d)
            row = tree.pieces[piece[limb]]
            assert piece[trunk] == row[4]
            assert tree.pieces[piece[trunk], 5] == 1
            assert trunk in tree.ancestors[piece[limb], : row[3]]


def test_limbs_follow_one_another_before_their_trunk(tree):
    assert tree.first_piece[0] == 0
    assert tree.first_piece[2] == len(tree.pieces)
    for k, (*_, n_ancestors, trunk, is_dense) in enumerate(tree.pieces):
        assert trunk > k if n_ancestors else trunk == k
        assert is_dense == (n_ancestors == 0 and k in tree.pieces[:k, 4])


def multiplications(tree, order, n_free):
    """Count those of the factors of an order, row by row of matrices whose rows are padded to eight numbers."""
    total = 0.0
    for k in range(tree.first_piece[order], tree.first_piece[order + 1]):
        _, _, n, n_ancestors, _, is_dense = tree.pieces[k]
        n_blocks, m = (1, 8 * -(-n * n_free // 8)) if is_dense else (n_free, 8 * -(-n // 8))
        for i in range(n_blocks):
            columns = n_ancestors * (i + 1)  # that are not zero in the row of pose i, about
            total += sum((q if i == 0 else m + q) * (2 * m - q + columns) for q in range(m)) / (2 if is_dense else 1)
            total += m * columns**2 / 2
    return total


@pytest.mark.parametrize("name", ["hands", "many fingers"])
def test_limbs_are_eliminated_first_where_that_takes_fewer_multiplications(name):
    tree = tree_of(SKELETONS[name])
    assert tree.first_piece[2] - tree.first_piece[1] > tree.first_piece[1]
    assert tree.most_poses[0] == _pieces.N_FREE[-1]
    for n_free in _pieces.N_FREE:
        assert multiplications(tree, 1, n_free) < _pieces.WORTH * multiplications(tree, 0, n_free)


@pytest.mark.parametrize("name", ["humanoid", "chain", "face", "root alone"])
def test_other_skeletons_have_no_limbs(name):
    tree = tree_of(SKELETONS[name])
    assert tree.most_poses[0] == 0
    first, second = (tree.pieces[tree.first_piece[i] : tree.first_piece[i + 1]] for i in range(2))
    np.testing.assert_array_equal(first[:, [0, 1, 2, 3, 5]], second[:, [0, 1, 2, 3, 5]])
