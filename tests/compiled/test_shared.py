"""A tree as compiled functions see it: the same fields, in and out of Python, and nothing is kept when it is done."""

import sys

import numpy as np
import pytest
from conftest import random_tree
from numba import njit

from skpose._compiled.pose.tree import Tree
from skpose._compiled.simd.shared import replace
from skpose.kinematics._tree import tree_of


@njit
def unchanged(tree):
    return tree


@njit
def with_offset(tree, offset):
    return replace(tree, "offset", offset)


@njit
def reach(tree):
    total = 0.0
    for j in range(tree.offset.shape[0]):
        total += np.abs(tree.offset[j]).sum()
    return total


@pytest.mark.slow
def test_fields_are_read_and_one_is_replaced():
    tree = tree_of(random_tree(0))
    assert reach(tree) == pytest.approx(np.abs(tree.offset).sum())
    for found, change in ((unchanged(tree), 0.0), (with_offset(tree, tree.offset + 1.0), 1.0)):
        for name, ours, expected in zip(Tree._fields, found, tree, strict=True):
            np.testing.assert_array_equal(ours, expected + change if name == "offset" else expected)


@pytest.mark.parametrize("function", [reach, unchanged, lambda tree: with_offset(tree, tree.offset)])
def test_memory_is_freed(function):
    """A structure that is not freed holds its arrays."""
    tree = tree_of(random_tree(0))
    function(tree)
    before = [sys.getrefcount(field) for field in tree]
    for _ in range(10):
        function(tree)
    assert [sys.getrefcount(field) for field in tree] == before
