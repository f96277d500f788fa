"""The page to try draws people as all other pages do: its finder and its shapes are those of the library.

The files are those of `rigs`, and people at random with the names of every table: joints are left out, moved and
stretched, names are decorated, chains have ends, hands have fingers, and some have a tail.
"""

import io
import json
import warnings

import numpy as np
import pytest
from pages_to_try import DATA, drop, open_drop_page, open_window, page_data
from rigs import POINTS, RIGS, Joint, file_of, hierarchy, random_segments

from skpose import Motion
from skpose.datasets import humanoid
from skpose.io import load_bvh, save_bvh
from skpose.kinematics._landmarks import TABLES
from skpose.kinematics._rigs import RIGS as ALL_RIGS
from skpose.kinematics._shape import find_shape
from skpose.skeleton._sides import others, split_sides

BVH_RIGS = [rig for rig in ALL_RIGS if rig.frame != "own"]
LEG = ("hip", "knee", "ankle", "ball", "toe")
ARM = ("collar", "shoulder", "elbow", "wrist", "hand")
PLACES = {**POINTS, "head_top": POINTS["top"], "head_center": (0.0, 0.72, 0.02)}
DECORATED = [
    *("{}", "mixamorig:{}", "Bip01 {}", "{}_1", "{}.001", "SK_{}", "a:b:{}", "l{}", "{}_2_end"),
    *("Größe {}", "Ⅻ.{}", "{}.٣"),
]
FACE = ["nose", "left_ear", "right_ear", "Left_Ear", "jaw"]
SHAPES = """(texts) => texts.map((text) => {
  const { skeleton } = drop.motionOf(drop.readBvh(text), 0.01);
  return { names: skeleton.names, sides: skeleton.sides, ...drop.shapeOf(skeleton) };
})"""


@pytest.fixture(scope="module")
def window():
    yield from open_window()


@pytest.fixture(scope="module")
def dropped(window, tmp_path_factory):
    """The page into which files are dropped."""
    return open_drop_page(window, tmp_path_factory.mktemp("drop"))


def assert_drawn_as_by_the_library(dropped, texts):
    """Compare the shapes of files; return which of them are people."""
    people = []
    for text, found in zip(texts, dropped.run(f"({SHAPES})({json.dumps(texts)})"), strict=True):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            skeleton = load_bvh(io.StringIO(text), scale=0.01, up="y").skeleton
        shape = find_shape(skeleton)
        assert found["names"] == list(skeleton.joint_names)
        assert found["parts"] == [[joint, [list(hull) for hull in hulls]] for joint, hulls in shape.parts]
        for ours, sphere in zip(found["spheres"], shape.spheres, strict=True):
            assert ours["at"] == list(sphere.points)
            assert ours.get("inside", False) == sphere.inside
            assert ours["radius"] == pytest.approx(sphere.radius, rel=1e-13)
            assert ours.get("weights", []) == pytest.approx(list(sphere.weights), abs=1e-13)
            for name in ("along", "across"):
                start, end, length = ours.get(name, (None, None, None))
                if (shift := getattr(sphere, name)) is None:
                    assert length is None
                    continue
                assert (start, end) == (list(shift.start), list(shift.end))
                assert length == pytest.approx(shift.length, rel=1e-12)
        people.append(shape.is_person)
    return people


def a_person(rig, rng):
    """The text of a BVH file of a person, or nearly one, with the names of a table."""
    joints = {"root": Joint("root", None, np.zeros(3), "pelvis")}
    hips = ["root", "z"][rng.integers(2)]  # what carries the legs, and the trunk or not
    if hips != "root":
        joints[hips] = Joint(hips, "root", np.array([0.0, 0.01, 0.0]), "x")
    chest = str(rng.choice(list(joints)))
    middle = [name for name, mark in rig.middle.items() if not mark]
    neck = [name for name in middle if any(word in name.lower() for word in ("neck", "nose", "jaw"))]
    trunk = [name for name in middle if name not in neck] if rng.random() < 0.8 else []
    for i, name in enumerate(trunk, start=1):
        joints[name] = Joint(name, chest, np.array([0.0, 0.48 * i / len(trunk), 0.0]), "x")
        chest = name

    def add(name, parent, point):
        size = np.exp(rng.normal(scale=0.05))
        joints.setdefault(name, Joint(name, parent, size * np.array(point, dtype=float), "x"))
        return name

    for name in neck:
        add(name, chest, (0, 0.55, 0.02))
    shoulder = next(name for name, mark in rig.left.items() if mark == "shoulder")
    for side, sign in (("left", 1.0), ("right", -1.0)):
        names = (
            dict(rig.left)
            if side == "left"
            else dict(zip((others(name)[0] for name in rig.left), rig.left.values(), strict=True))
        )
        by_mark = {mark: name for name, mark in names.items() if mark}
        for chain, start in ((LEG, hips), (ARM, chest)):
            before = start
            for mark in chain:
                if mark in by_mark:
                    before = add(by_mark[mark], before, np.multiply(PLACES[mark], [sign, 1, 1]))
        for name, mark in names.items():
            if name not in joints:
                before = by_mark["wrist"] if mark == "hand" or rng.random() < 0.4 else str(rng.choice(list(joints)))
                add(name, before, joints[before].point + rng.normal(scale=0.03, size=3))
        if rng.random() < 0.2:
            for i in range(5):
                before = by_mark["wrist"]
                for k in range(2):
                    point = np.add(joints[before].point, [sign * 0.05, 0.0, 0.02 * (i - 2) * (1 - k)])
                    before = add(f"{side}_f{i}_{k}", before, point)
    before = shoulder if rng.random() < 0.05 else chest
    for name, mark in rig.middle.items():
        if mark:
            before = add(name, before, PLACES[mark])
    return damaged(joints, rng)


def damaged(joints, rng):
    """The text of a file of joints, of which some are left out, or elsewhere, and whose names are decorated."""

    def happens(probability):
        return rng.random() < probability

    def leave_out(name):
        for other, joint in list(joints.items()):
            if joint.parent == name:
                joints[other] = joint._replace(parent=joints[name].parent)
        del joints[name]

    def one():
        return str(rng.choice(list(joints)[1:]))

    for _ in range(rng.integers(4) if happens(0.3) else 0):
        leave_out(one())
    if happens(0.2):
        name = one()
        joints[name] = joints[name]._replace(parent=str(rng.choice(["root", one()])))
        joints = depth_first(joints)
    if happens(0.2):
        name = one()
        above = joints[name].parent
        for other in (name, above):  # three joints at one place
            joints[other] = joints[other]._replace(point=joints[joints[above].parent or "root"].point)
    if happens(0.1):
        tail = str(rng.choice(["Tail", "tail_01", "LeftWing", "Paw"]))
        joints[tail] = Joint(tail, "root", np.full(3, 0.1), "x")
    if happens(0.2):
        for name in FACE[: rng.integers(1, 6)]:
            if name not in joints:
                joints[name] = Joint(name, list(joints)[-1], rng.normal((0, 0.7, 0), 0.05), "x")
    points = {name: joint.point * (rng.uniform(0.5, 3) if happens(0.004) else 1.0) for name, joint in joints.items()}
    offsets = {
        name: 100.0 * (points[name] - points[joint.parent] if joint.parent else joint.point)
        for name, joint in joints.items()
    }
    for name in [name for name in joints if not any(other.parent == name for other in joints.values())]:
        if happens(0.7):
            ending, segment = [("_end", ""), ("_End", "x"), ("Nub", "x"), ("_end", "x")][rng.integers(4)]
            joints[name + ending] = Joint(name + ending, name, np.zeros(3), segment)
            offsets[name + ending] = 100.0 * rng.normal(scale=0.05, size=3) * (0.0 if happens(0.2) else 1.0)
    pattern = str(rng.choice(DECORATED)) if happens(0.5) else "{}"
    change = rng.choice([str, str.lower, str.upper]) if happens(0.3) else str
    lines = list(hierarchy(joints, offsets, lambda name: change(pattern.format(name))))
    n_numbers = 3 + 3 * sum(line.strip().startswith(("ROOT", "JOINT")) for line in lines)
    return "\n".join(["HIERARCHY", *lines, "MOTION", "Frames: 1", "Frame Time: 0.1", " ".join(["0"] * n_numbers), ""])


def depth_first(joints):
    """Joints whose parents come before them; those of a circle are left out."""
    found = {}
    while new := {k: j for k, j in joints.items() if k not in found and (j.parent is None or j.parent in found)}:
        found |= new
    return found


@pytest.mark.parametrize("rig", BVH_RIGS, ids=lambda rig: rig.name)
def test_people_at_random(dropped, rig):
    rng = np.random.default_rng(sum(map(ord, rig.name)))
    people = assert_drawn_as_by_the_library(dropped, [a_person(rig, rng) for _ in range(40)])
    assert 8 < sum(people) < 39


@pytest.mark.parametrize("name", RIGS)
def test_files_of_rigs(dropped, name):
    rig, segments = RIGS[name], random_segments(2)
    last = next(row[0] for row in rig.arm if row[1] == "wrist")
    arm = next(row[0] for row in rig.arm if row[1] == "elbow")
    neck = next(row[0] for row in rig.neck if row[1] in ("neck", ""))
    changes = [{}, {"leave_out": [last]}, {"leave_out": [neck]}, {"leave_out": [arm]}, {"stretch": {arm: 1.6}}]
    changes += [{"stretch": {arm: 5.0}}, {"rename": lambda name: f"x{name}"}, {"rename": lambda name: f"{name}.001"}]
    people = assert_drawn_as_by_the_library(dropped, [file_of(rig, segments, **change)[0] for change in changes])
    assert people[0]
    assert not people[4]
    assert people[-1]


@pytest.mark.parametrize(("letters", "is_person"), [("𐀀", True), ("𐀀𐀁", False)])
def test_a_letter_is_one_letter(dropped, letters, is_person):
    """Two numbers of JavaScript's each, of which the first are equal."""
    rig = next(iter(RIGS.values()))
    text = file_of(rig, random_segments(2), rename=lambda name: letters[len(name) % len(letters)] + name)[0]
    assert assert_drawn_as_by_the_library(dropped, [text]) == [is_person]


def test_files_of_the_page_and_of_no_people(dropped):
    texts = [one["text"] for one in page_data(drop.page())["examples"]]
    texts += [path.read_text(encoding="utf-8") for path in sorted(DATA.glob("*.bvh"))]
    assert assert_drawn_as_by_the_library(dropped, texts)[:2] == [True, True]


@pytest.mark.parametrize("folder", ["cmu", "hdm05"])
def test_people_of_databases(dropped, folder, request, tmp_path):
    texts = []
    motions = {motion.skeleton.joint_names: motion for motion in request.getfixturevalue(folder).motions}
    for i, motion in enumerate(motions.values()):
        save_bvh(tmp_path / f"{i}.bvh", motion[:2], scale=0.01)
        texts.append((tmp_path / f"{i}.bvh").read_text(encoding="utf-8"))
    assert all(assert_drawn_as_by_the_library(dropped, texts))


def test_a_written_person_of_our_own(dropped, tmp_path):
    skeleton = humanoid()
    save_bvh(tmp_path / "own.bvh", Motion(skeleton, np.zeros((1, skeleton.n_dofs)), 25), scale=0.01)
    assert assert_drawn_as_by_the_library(dropped, [(tmp_path / "own.bvh").read_text(encoding="utf-8")]) == [True]


def test_sides_of_names(dropped):
    """Of words that are put together at random, with the other side of some."""
    rng = np.random.default_rng(0)
    words = [
        "left",
        "Right",
        "LEFT",
        "l",
        "R",
        "L",
        "_",
        " ",
        "arm",
        "Leg",
        "ı",
        "9",
        "rıght",
        "RİGHT",
        "lleft",
        "é",
        ".",
    ]
    names = ["".join(rng.choice(words, rng.integers(1, 5))) for _ in range(400)]
    names += [other for name in names[:200] for other in others(name)]
    found = dropped.run(f"drop.splitSides({json.dumps(names)}).map(({{ side, rest }}) => [side, rest])")
    assert [tuple(one) for one in found] == split_sides(names)
    assert len({side for side, _ in found}) == 3


def test_the_page_has_the_names_of_the_left_alone():
    """Those of the right are the same, but for the side."""
    for table in TABLES.values():
        left, right = ({rest: mark for (one, rest), mark in table.items() if one == side} for side in ("left", "right"))
        assert right == {rest: mark.replace("left_", "right_") for rest, mark in left.items()}
