"""Skeletons as mappings of joint names to bones."""

import copy
import pickle

import numpy as np
import pytest
from conftest import SKELETONS
from sklearn.model_selection import GridSearchCV
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import Skeleton
from skpose.datasets import humanoid
from skpose.preprocessing import PoseDistanceTransformer
from skpose.skeleton._sides import sides

PERSON = humanoid()


@pytest.mark.parametrize("skeleton", SKELETONS.values(), ids=SKELETONS)
def test_a_skeleton_maps_names_to_bones(skeleton):
    assert len(skeleton) == skeleton.n_joints
    assert list(skeleton) == list(skeleton.joint_names)
    assert {name: skeleton[name] for name in skeleton} == {bone.name: bone for bone in skeleton.bones}
    assert all(name in skeleton for name in skeleton)


@pytest.mark.parametrize("name", ["left_hnd", "LEFT_HAND"])
def test_similar_names_are_suggested(name):
    with pytest.raises(KeyError, match="left_hand"):
        PERSON[name]


def test_arrays_and_grid_searches_take_a_skeleton_as_one_object():
    """Without care numpy would make a table of names of a list of skeletons."""
    skeletons = [Skeleton.chain(2), Skeleton.chain(2).to_rotvec()]
    array = np.array(skeletons)
    assert (array.shape, array.dtype) == ((2,), object)
    assert list(array) == skeletons
    X, y = np.random.default_rng(0).uniform(-1, 1, (20, 2)), np.arange(20) % 2
    knn = make_pipeline(PoseDistanceTransformer(), KNeighborsClassifier(1, metric="precomputed"))
    skeletons = [Skeleton.chain(2), Skeleton.chain(2).to_euler("xyz")]
    search = GridSearchCV(knn, {"posedistancetransformer__skeleton": skeletons}, cv=2).fit(X, y)
    assert list(search.cv_results_["param_posedistancetransformer__skeleton"]) == skeletons


def test_copies_and_pickles_are_unchanged():
    for other in (copy.copy(PERSON), copy.deepcopy(PERSON), pickle.loads(pickle.dumps(PERSON))):
        assert other == PERSON
        assert hash(other) == hash(PERSON)


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["LeftArm", "RightArm", "Spine"], ["left", "right", ""]),
        (["hand_left", "hand_right", "mixamorig:LeftHand"], ["left", "right", "left"]),
        (["L_Hip", "hip.r", "Bip01 L Arm"], ["left", "right", "left"]),
        (["lfemur", "rfemur", "lowerback", "root"], ["left", "right", "", ""]),
        (["LHip", "RHip", "armLeft", "armRight"], ["left", "right", "left", "right"]),
        (["HipL", "HipR", "neck"], ["left", "right", ""]),
        (["LeftArm"], ["left"]),  # alone
        (["lclavicle", "thorax", "rotator"], ["", "", ""]),  # a letter without a partner
        (["joint_1", "joint_2"], ["", ""]),
        (["xr\u0131ght", "XR\u0130GHT"], ["", ""]),  # an i without a dot, and a capital with one
    ],
)
def test_sides_by_name(names, expected):
    assert sides(names) == expected
