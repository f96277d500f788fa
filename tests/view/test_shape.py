"""The shape of figures: people have the parts and the size of a person, and nothing else has."""

from itertools import pairwise

import numpy as np
import pytest
from conftest import SKELETONS
from rigs import motion_of, random_segments
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton, forward_kinematics
from skpose.kinematics._anatomy import find_anatomy
from skpose.kinematics._mass import ARM_SEGMENTS as ARM, LEG_SEGMENTS as LEG
from skpose.skeleton._proportions import PROPORTIONS
from skpose.view._shape import R_SKULL, find_shape, outline

# Of the people of de Leva's table: kg, g/cm³ and m give the volume of a person of height 1.

VOLUME = 67.5 / 1050.0 / 1.738**3

PEOPLE = ["humanoid", "Mixamo", "LAFAN1"]


def points_of(skeleton, pose=None):
    """The root and the joints of a pose, (n_joints + 1, 3)."""
    pose = np.zeros(skeleton.n_dofs) if pose is None else pose
    return np.concatenate([np.zeros((1, 3)), forward_kinematics(pose[None], skeleton)[0]])


def skeleton_of(name):
    return SKELETONS[name] if name == "humanoid" else motion_of(name, random_segments(2))[0].skeleton


def height_of(skeleton):
    joints = find_anatomy(skeleton).joints
    where = points_of(skeleton)[1:]
    ends = [where[joints[f"left_{mark}"]] for mark in ("hip", "knee", "ankle")]
    leg = sum(np.linalg.norm(b - a) for a, b in pairwise(ends))
    return leg / (PROPORTIONS["thigh"] + PROPORTIONS["shank"])


@pytest.mark.parametrize("name", PEOPLE)
def test_people_of_every_rig_have_a_head_of_a_persons_size_above_the_shoulders(name):
    skeleton = skeleton_of(name)
    shape, joints = find_shape(skeleton), find_anatomy(skeleton).joints
    assert shape.is_person
    points, height = points_of(skeleton), height_of(skeleton)
    if not {"head", "head_top", "head_center"} & joints.keys():
        return
    skull = [i for i, s in enumerate(shape.spheres) if s.radius == pytest.approx(R_SKULL * height, rel=0.05)]
    (skull,) = [i for i in skull if shape.spheres[i].along is not None]
    centres = shape.centres(points)
    hips, shoulders = (
        points[[joints[f"{side}_{mark}"] + 1 for side in ("left", "right")]].mean(axis=0)
        for mark in ("hip", "shoulder")
    )
    up = (shoulders - hips) / np.linalg.norm(shoulders - hips)
    above = (centres[skull] - shoulders) @ up / height
    assert 0.06 < above < 0.25  # the middle of the skull; 0.13 in the mean of people
    (hull,) = [part.hulls[0] for part in shape.parts if skull in part.hulls[0]]
    ends = np.concatenate([centres[list(hull)] @ up + sign * shape.radii[list(hull)] for sign in (-1, 1)])
    assert np.ptp(ends) / height == pytest.approx(PROPORTIONS["head"], rel=0.15)


@pytest.mark.parametrize("name", PEOPLE)
def test_a_figure_reaches_all_joints_of_a_person(name):
    skeleton = skeleton_of(name)
    shape, pose = find_shape(skeleton), np.random.default_rng(0).normal(scale=0.3, size=skeleton.n_dofs)
    points = points_of(skeleton, pose)
    centres, radii = shape.centres(points), shape.radii[:, None]
    slack = 0.02 * height_of(skeleton)
    assert ((centres - radii).min(axis=0) <= points.min(axis=0) + slack).all()
    assert ((centres + radii).max(axis=0) >= points.max(axis=0) - slack).all()


@pytest.mark.parametrize("name", PEOPLE[:2])
def test_shapes_turn_and_grow_with_the_figure(name):
    skeleton = skeleton_of(name)
    shape = find_shape(skeleton)
    points = points_of(skeleton, np.random.default_rng(1).normal(scale=0.4, size=skeleton.n_dofs))
    turn, moved = Rotation.from_rotvec([0.3, -1.2, 0.7]), np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(
        shape.centres(turn.apply(points) + moved), turn.apply(shape.centres(points)) + moved, atol=1e-12
    )
    larger = Skeleton(
        [Bone(b.name, b.parent, tuple(100 * np.array(b.offset)), b.dofs) for b in skeleton.bones],
        offset_frame=skeleton.offset_frame,
    )
    grown = find_shape(larger)
    np.testing.assert_allclose(grown.radii, 100 * shape.radii)
    np.testing.assert_allclose(grown.centres(100 * points), 100 * shape.centres(points), atol=1e-9)
    assert grown.parts == shape.parts


def volume(shape, points, joint):
    """The volume of a part by its joint: of the cones between the spheres of its hull, in their order."""
    (hull,) = [part.hulls[0] for part in shape.parts if part.joint == joint]
    centres, radii = shape.centres(points)[list(hull)], shape.radii[list(hull)]
    lengths = np.linalg.norm(np.diff(centres, axis=0), axis=1)
    return float((np.pi / 3 * lengths * (radii[:-1] ** 2 + radii[:-1] * radii[1:] + radii[1:] ** 2)).sum())


def test_segments_of_limbs_have_the_volume_of_their_mass():
    skeleton = SKELETONS["humanoid"]
    shape, joints, points = find_shape(skeleton), find_anatomy(skeleton).joints, points_of(skeleton)
    unit = VOLUME * height_of(skeleton) ** 3
    for mark, segment in (("knee", LEG[0]), ("ankle", LEG[1]), ("elbow", ARM[0]), ("wrist", ARM[1])):
        found = volume(shape, points, joints[f"left_{mark}"])
        assert found / (segment.mass * unit) == pytest.approx(1.0, abs=0.21), mark


@pytest.mark.parametrize("name", [name for name in SKELETONS if name not in ("humanoid", "bvh")][:3])
def test_what_is_no_person_has_links_alone(name):
    skeleton = SKELETONS[name]
    shape = find_shape(skeleton)
    assert not shape.is_person
    assert [part.joint for part in shape.parts] == list(range(skeleton.n_joints))
    assert all(len(part.hulls) == 1 and len(part.hulls[0]) <= 2 for part in shape.parts)
    assert all(len(sphere.at) == 1 and sphere.along is None for sphere in shape.spheres)


def test_radii_of_links_meet_and_bones_without_length_are_there():
    arm = Skeleton(
        [Bone("a", None, (0, 0, 0.5), "z"), Bone("b", "a", (0, 0, 0), "z"), Bone("c", "b", (0, 0, 0.02), "x")]
    )
    shape = find_shape(arm)
    assert [len(part.hulls[0]) for part in shape.parts] == [2, 1, 2]
    of_point = {sphere.at[0]: sphere.radius for sphere in shape.spheres}
    assert of_point[2] == pytest.approx(of_point[1])
    assert of_point[1] > of_point[3] > 0


def test_an_outline_is_that_of_the_hull_of_discs():
    rng = np.random.default_rng(0)
    angles = np.linspace(0, 2 * np.pi, 2000)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for n in (1, 2, 5):
        centres, radii = rng.normal(size=(n, 2)), rng.uniform(0.1, 0.6, n)
        exact = ConvexHull((centres[:, None] + radii[:, None, None] * circle).reshape(-1, 2)).volume
        found = outline(centres, radii)
        assert 0.98 * exact < ConvexHull(found).volume <= exact
        around = np.unwrap(np.arctan2(*(found - found.mean(axis=0)).T[::-1]))
        assert (np.diff(around) >= -1e-9).all()  # in order
