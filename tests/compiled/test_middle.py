"""Two chords as a lower bound of a straight line's length."""

import numpy as np
import pytest
from conftest import MIXED, random_tree

from skpose import Skeleton, pose_distances
from skpose._compiled.pose.loops import encode_poses, in_lanes
from skpose._compiled.pose.nearest import bounds_of_groups
from skpose._compiled.pose.tree import Steps
from skpose._compiled.simd.lanes import lanes
from skpose.kinematics._tree import tree_of
from skpose.metrics import Spatial

FLOAT32 = np.dtype(np.float32)
LANES = lanes(FLOAT32)
COARSE = Spatial().coarse_bound
SKELETONS = {
    "mixed joints": random_tree(3, n=6, kinds=MIXED, offset_frame="parent"),
    "deep": random_tree(5, n=25, kinds=MIXED),
    "long chain": Skeleton.chain(60),
}


def two_chords(X, Y, skeleton):
    """The least bound of each pose, alone in a group: the lanes hold copies of it."""
    tree, steps = tree_of(skeleton), Steps.of(10, wrap=True)
    n_codes = COARSE.n_codes(tree)
    codes, others = np.empty((len(X), n_codes)), np.empty((len(Y), n_codes))
    encode_poses(X, COARSE.encode, tree, steps, codes)
    encode_poses(Y, COARSE.encode, tree, steps, others)
    groups = in_lanes(np.repeat(others, LANES, axis=0).astype(FLOAT32))
    bounds, limits = np.zeros((len(X), len(Y)), FLOAT32), np.zeros(len(X), FLOAT32)
    tail = limits, COARSE.measure, tree_of(skeleton, FLOAT32), steps, bounds
    bounds_of_groups(codes.astype(FLOAT32), groups, 0, len(X), *tail)
    return bounds


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("name", SKELETONS)
def test_two_chords_are_never_longer_than_the_line_but_for_their_slack(name, size):
    """Poses near and far, equal, whole turns apart, and half a turn apart but for a rounding of float32."""
    bones = [bone._replace(offset=tuple(size * x for x in bone.offset)) for bone in SKELETONS[name].bones]
    skeleton = Skeleton(bones)
    rng = np.random.default_rng(0)
    X = rng.uniform(-4, 4, size=(4, skeleton.n_dofs))
    Y = [X + distance * rng.normal(size=X.shape) for distance in (0.0, 1e-6, 1e-2, 0.3, 3.0)]
    turns = np.pi * rng.integers(-2, 3, X.shape)
    Y = np.concatenate([*Y, X + turns, *(X + turns + e * rng.normal(size=X.shape) for e in (1e-9, 1e-7, 1e-5))])
    lengths = pose_distances(X, Y, skeleton=skeleton, metric=Spatial())
    bounds, slack = two_chords(X, Y, skeleton), COARSE.slack(tree_of(skeleton))
    assert (bounds <= lengths + slack).all()
    assert slack < 1e-2 * lengths.max()
    exact = pose_distances(X, Y, skeleton=skeleton, metric=Spatial(2))
    far = slice(0, 5 * len(X))  # where the middle is certain
    assert (np.abs(bounds - exact)[:, far] < slack).mean() > 0.95
    assert (bounds >= 0.0).all()
