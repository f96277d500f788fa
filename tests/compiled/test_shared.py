"""A tree as compiled functions see it: the same fields, in and out of Python, and nothing is kept when it is done."""

import sys
from collections import namedtuple

import numpy as np
import pytest
from conftest import random_tree
from numba import njit

from skpose._compiled.pose.tree import Tree
from skpose._compiled.simd.shared import replace, shared
from skpose.kinematics._tree import tree_of

Constants = namedtuple("Constants", Tree._fields)  # the fields, as numba has named tuples


@njit
def unchanged(tree):
    return tree


@njit
def rebuilt(fields):
    return shared(Tree(*fields))


@njit
def with_offset(tree, offset):
    return replace(tree, "offset", offset)


@njit
def reach(tree):
    total = 0.0
    for j in range(tree.offset.shape[0]):
        total += np.abs(tree.offset[j]).sum()
    return total


@pytest.mark.parametrize("function", [unchanged, lambda tree: rebuilt(Constants(*tree))])
def test_a_tree_comes_back_as_it_was(function):
    tree = tree_of(random_tree(0))
    found = function(tree)
    assert isinstance(found, Tree)
    for ours, expected in zip(found, tree, strict=True):
        np.testing.assert_array_equal(ours, expected)


def test_fields_are_read_in_compiled_code():
    tree = tree_of(random_tree(0))
    np.testing.assert_allclose(reach(tree), np.abs(tree.offset).sum())


def test_one_array_is_replaced():
    tree = tree_of(random_tree(0))
    found = with_offset(tree, tree.offset + 1.0)
    for name, ours, expected in zip(Tree._fields, found, tree, strict=True):
        np.testing.assert_array_equal(ours, expected + 1.0 if name == "offset" else expected)


KEEPING = [reach, unchanged, lambda tree: rebuilt(Constants(*tree)), lambda tree: with_offset(tree, tree.offset)]


@pytest.mark.parametrize("function", KEEPING)
def test_nothing_is_kept(function):
    """A structure that is not freed holds its arrays."""
    tree = tree_of(random_tree(0))
    function(tree)
    before = [sys.getrefcount(field) for field in tree]
    for _ in range(10):
        function(tree)
    assert [sys.getrefcount(field) for field in tree] == before
