"""What the page of an explorer holds: poses rounded by a known amount, embeddings, labels, which axis points up."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import SKELETONS
from pages import data_of
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, forward_kinematics
from skpose.datasets import MotionDataset, make_gait
from skpose.manifold import SpatialMDS
from skpose.view import Page, _explorer, explorer
from skpose.view._scene import unpack

STEP = 2 * np.pi / 65536


@pytest.fixture(scope="module")
def gait():
    """Four motions of two people."""
    return make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=24, random_state=0)


@pytest.fixture(scope="module")
def page(gait):
    return explorer(gait)


def some_poses(n, skeleton=None, seed=0, scale=0.4):
    """A motion of random poses."""
    skeleton = skeleton or Skeleton.chain(3)
    return Motion(skeleton, np.random.default_rng(seed).normal(scale=scale, size=(n, skeleton.n_dofs)), 30)


@pytest.mark.parametrize("name", ["humanoid", "bvh"])
def test_poses_are_those_of_the_dataset_but_for_half_a_step(name):
    dataset = MotionDataset([some_poses(12, SKELETONS[name], seed, scale=2.0) for seed in range(3)])
    data = data_of(explorer(dataset, frame_rate=20, metrics=["position"]))
    X, sequence = dataset.poses(20)
    found = unpack(data["poses"])
    assert np.abs(found - X).max() <= STEP / 2 * (1 + 1e-6)
    assert data["counts"] == np.bincount(sequence).tolist()
    moved = [forward_kinematics(poses, dataset.skeleton) for poses in (found, X)]
    error = np.linalg.norm(moved[0] - moved[1], axis=2).max()
    assert data["error"] == pytest.approx(1e3 * error, rel=1e-6)  # stated as it is, mm


def test_every_frame_and_its_time():
    motion = replace(some_poses(4), frame_numbers=[3, 4, 8, 20])
    data = data_of(explorer(MotionDataset([motion, some_poses(2)]), frame_rate=None))
    np.testing.assert_allclose(unpack(data["times"])[:, 0], [*motion.times, 0, 1 / 30], atol=5e-4)
    assert (data["counts"], data["rate"]) == ([4, 2], 30.0)


def test_error_of_people_is_a_fraction_of_a_millimetre(gait, page):
    error = data_of(page)["error"]
    assert 0.01 < error < 0.3
    assert page.note == f"48 poses of 4 motions, positions within {error:.2g} mm"
    assert (page.title, explorer(gait, title="people", metrics=["angle"]).title) == ("48 poses of 4 motions", "people")
    assert isinstance(page, Page)


@pytest.mark.parametrize(("up", "turn"), [("x", (0, 0, 0)), ("y", (90, 0, 0)), ("z", (180, 20, 30))], ids=str)
def test_up_in_the_page_is_up_in_the_world(up, turn):
    """The root's own axes may be any: its orientation brings them into the world."""
    angles = np.tile(np.radians(turn), (5, 1))
    motion = replace(some_poses(5), root_angles=angles, root_axes="XYZ", up=up)
    found = data_of(explorer(MotionDataset([motion]), metrics=["position"], frame_rate=None))["up"]
    to_page = np.zeros((3, 3))
    to_page[range(3), found["order"]] = found["signs"]
    assert np.linalg.det(to_page) == pytest.approx(1.0)  # no mirror
    vertical = Rotation.from_euler("XYZ", angles[0]).inv().apply(np.eye(3)["xyz".index(up)])
    assert (to_page @ vertical)[1] > np.cos(np.radians(40))
    named = ["xyz"[axis] if sign > 0 else "" for axis, sign in zip(found["order"], found["signs"], strict=True)]
    assert found["names"] == named


def test_embeddings_are_those_of_spatial_mds(gait, page):
    X, _ = gait.poses(12)
    embeddings = data_of(page)["embeddings"]
    assert [one["metric"] for one in embeddings] == ["spatial", "position", "rotation", "angle"]
    assert [one["unit"] for one in embeddings] == ["m", "m", "m", "rad"]
    first = unpack(embeddings[0]["points"])
    for one in embeddings:
        mds = SpatialMDS(gait.skeleton, n_components=2, metric=one["metric"]).fit(X)
        points = unpack(one["points"])
        signs = np.sign((points * mds.embedding_).sum(axis=0))
        np.testing.assert_allclose(points, mds.embedding_ * signs, atol=np.ptp(points) / 65535)
        assert one["share"] == pytest.approx(mds.explained_variance_ratio_.sum())
        assert ((points * first).sum(axis=0) >= 0).all()  # the axes of all point to one side


def test_many_poses_are_placed_by_landmarks(gait, monkeypatch):
    monkeypatch.setattr(_explorer, "ALL", 40)
    monkeypatch.setattr(_explorer, "LANDMARKS", 20)
    (one,) = data_of(explorer(gait, metrics=["position"]))["embeddings"]
    mds = SpatialMDS(gait.skeleton, n_components=2, metric="position", landmarks=20, random_state=0)
    expected = mds.fit_transform(gait.poses(12)[0])
    np.testing.assert_allclose(unpack(one["points"]), expected, atol=np.ptp(expected) / 65535)


def test_labels_are_those_of_the_dataset(gait, page):
    data = data_of(page)
    parts = zip(gait.subjects, gait.actions, gait.trials, strict=True)
    assert data["labels"] == [" · ".join(part) for part in parts]
    for group, values in zip(data["groups"], (gait.subjects, gait.actions), strict=True):
        assert np.array(group["names"])[group["of"]].tolist() == values.tolist()
    assert [group["by"] for group in data["groups"]] == ["subject", "action"]


def test_groups_are_sorted_by_the_numbers_in_their_names(gait):
    given = ["10", "2", "a10", "a2b"]
    groups = data_of(explorer(MotionDataset(gait.motions, subjects=given), metrics=["angle"]))["groups"]
    assert groups == [{"by": "subject", "names": ["2", "10", "a2b", "a10"], "of": [1, 0, 3, 2]}]
    same = MotionDataset(gait.motions, subjects=["1", "001", "01", "0001"])  # equal numbers have an order too
    assert data_of(explorer(same, metrics=["angle"]))["groups"][0]["names"] == ["0001", "001", "01", "1"]


def test_labels_may_be_missing_or_given(gait):
    bare = data_of(explorer(MotionDataset(gait.motions), metrics=["angle"]))
    assert bare["labels"] == ["motion 1", "motion 2", "motion 3", "motion 4"]
    assert bare["groups"] == []
    some = MotionDataset(gait.motions[:2], actions=["", "walk"])
    assert data_of(explorer(some, metrics=["angle"]))["labels"] == ["motion 1", "walk"]
    assert data_of(explorer(some, metrics=["angle"], labels=["a", "b"]))["labels"] == ["a", "b"]
    same = MotionDataset(gait.motions[:3], actions=["walk", "run", "walk"])
    assert data_of(explorer(same, metrics=["angle"]))["labels"] == ["walk (1)", "run", "walk (2)"]


def test_no_name_is_markup():
    names = ["<script>alert(1)</script>", "</script><!--", "\udc80"]
    skeleton = Skeleton(Bone(name, None, (0.1 * i, 1, 0), "z") for i, name in enumerate(names))
    motions = [some_poses(3, skeleton, seed) for seed in range(3)]
    page = explorer(MotionDataset(motions, names, names, names), title="</title><script>", frame_rate=None)
    assert data_of(page)["skeleton"]["names"] == names
    assert page.html.count("<script") == 2  # data and program
    assert page.html.count("</title>") == 1
    page.html.encode("utf-8")
    assert "<script" not in page._repr_html_()


@pytest.mark.parametrize(
    "arguments",
    [
        {"metrics": "spatial"},
        {"metrics": ["euclidean"]},
        {"embeddings": ["pca"]},
        {"labels": ["a"]},
        {"frame_rate": -1},
    ],
    ids=str,
)
def test_wrong_arguments_are_refused(gait, arguments):
    with pytest.raises(ValueError, match=next(iter(arguments))):
        explorer(gait, **arguments)


def test_too_few_poses_and_slides_are_refused():
    lift = Skeleton([Bone("lift", None, (0, 0, 0.2), "slide", axis=(0, 0, 1)), Bone("hand", "lift", (0.3, 0, 0), "z")])
    with pytest.raises(ValueError, match="2 poses"):
        explorer(MotionDataset([some_poses(1)]))
    with pytest.raises(ValueError, match="slide"):
        explorer(MotionDataset([some_poses(4, lift)]))
