"""Faults are found where they are, and sound motions have no findings."""

import csv
from dataclasses import replace

import numpy as np
import pytest
import walkers

from skpose import Keypoints, Skeleton
from skpose._cli.main import main
from skpose.checks import check_motion
from skpose.datasets import make_actions, make_gait
from skpose.io import save_bvh


@pytest.fixture(scope="module")
def dataset():
    return make_actions(1, 1, actions=["kick", "reach"], rotations="file", random_state=0)


@pytest.fixture(scope="module")
def kick(dataset):
    return dataset[0]


def kinds(motions):
    return {finding.kind for finding in check_motion(motions)}


def of_kind(motions, kind):
    return next(finding for finding in check_motion(motions) if finding.kind == kind)


def rows_of(motion, rows):
    """The motion with these rows at the same times."""
    arrays = {name: getattr(motion, name)[rows] for name in ("angles", "root_positions", "root_angles")}
    return replace(motion, frame_numbers=None, **arrays)


def lifted(motion, heights):
    up = np.zeros((len(motion), 3))
    up[:, 1] = heights
    return replace(motion, root_positions=motion.root_positions + up)


def scaled(motion, factor):
    bones = [bone._replace(offset=tuple(factor * x for x in bone.offset)) for bone in motion.skeleton.bones]
    return replace(motion, skeleton=Skeleton(bones), root_positions=factor * motion.root_positions)


def exchanged(motion):
    """Left and right have each other's names."""
    other = {"left": "right", "right": "left"}

    def name(text):
        side, _, rest = (text or "").partition("_")
        return f"{other[side]}_{rest}" if side in other else text

    bones = [bone._replace(name=name(bone.name), parent=name(bone.parent)) for bone in motion.skeleton.bones]
    return replace(motion, skeleton=Skeleton(bones))


def test_sound_motions_have_no_findings(dataset):
    assert check_motion(dataset) == []
    assert check_motion(dataset[0]) == check_motion(iter(dataset)) == []


def test_a_finding_states_where_and_how_much(kick):
    n = 50
    found = of_kind(
        replace(kick, root_positions=kick.root_positions + 0.2 * (np.arange(len(kick)) >= n)[:, None]), "jump"
    )
    assert found.severity == "error"
    assert found.frames[0] <= n < found.frames[1] <= n + 3
    assert found.size == pytest.approx(0.2 * np.sqrt(3), rel=0.1)
    assert (found.unit, found.joints) == ("m", ("root",))
    assert f"frames {found.frames[0]} to" in str(found)


def spike(kick):
    angles = kick.angles.copy()
    angles[40, kick.skeleton.dof_names.index("left_shank_rx")] += 0.5
    return replace(kick, angles=angles)


def flip(kick):
    angles = kick.angles.copy()
    angles[40:, 3] += 2.0 * np.pi
    return replace(kick, angles=angles)


def noisy(kick):
    return replace(kick, angles=kick.angles + np.random.default_rng(0).normal(0.0, 0.01, kick.angles.shape))


def slides(kick):
    drift = np.zeros((len(kick), 3))
    drift[30:, 2] = 0.6 / kick.frame_rate * np.arange(len(kick) - 30)
    return replace(kick, root_positions=kick.root_positions + drift)


def bends_forward(kick):
    angles = kick.angles.copy()
    angles[:, kick.skeleton.dof_names.index("left_shank_rx")] *= -1.0
    return replace(kick, angles=angles)


FAULTS = {
    "missing frames": lambda kick: replace(kick[:60], frame_numbers=[*range(40), *range(50, 70)]),
    "repeated frames": lambda kick: rows_of(kick, np.arange(len(kick)) // 2 * 2),
    "interpolated frames": lambda kick: kick.resample(15).resample(60),
    "jump": spike,
    "noise": noisy,
    "angle flips": flip,
    "units": lambda kick: scaled(kick, 100.0),
    "up axis": lambda kick: replace(kick, up="z"),
    "calibration pose": lambda kick: replace(
        kick, angles=np.where(np.arange(len(kick))[:, None] < 3, 0.0, kick.angles)
    ),
    "floor": lambda kick: lifted(kick, 0.3),
    "floating": lambda kick: lifted(kick, 0.15 * (np.arange(len(kick)) > 70)),
    "sinking": lambda kick: lifted(kick, -0.15 * (np.arange(len(kick)) > 90)),
    "skating": slides,
    "sides exchanged": exchanged,
    "joint limits": bends_forward,
    "no frames": lambda kick: kick[:0],
}


@pytest.mark.parametrize("kind", FAULTS)
def test_faults_are_found(kick, kind):
    assert kind in kinds(FAULTS[kind](kick))


@pytest.fixture(scope="module")
def walk():
    """Eight steps at 109 a minute; the lower foot stands."""
    walk = make_gait(1, 1, activities=["walk"], duration=6, random_state=0)[0]
    feet = [walk.skeleton.joint_names.index(name) for name in ("left_foot", "right_foot")]
    balls = walk.positions()[:, feet]
    lower = balls[:-1, :, 1].argmin(axis=1)
    steps = -np.diff(balls, axis=0)[np.arange(len(lower)), lower]
    root = np.concatenate([[[0, 0, 0]], np.cumsum(steps, axis=0)])
    root[:, 1] = 0.03 - balls[:, :, 1].min(axis=1)
    return replace(walk, root_positions=root)


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0])
def test_wrong_frame_rates_of_walks(walk, factor):
    assert "frame rate" not in kinds(walk)
    assert "frame rate" in kinds(replace(walk, frame_rate=factor * walk.frame_rate))


@pytest.mark.parametrize("rate", [10.0, 15.0, 20.0])
def test_fast_feet_at_low_rates_are_no_jumps(rate):
    assert "jump" not in kinds(walkers.walk(rate=rate))


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.6])
def test_a_root_in_another_unit(walk, factor):
    assert "skating" not in kinds(walk)
    found = of_kind(replace(walk, root_positions=walk.root_positions * [factor, 1.0, factor]), "skating")
    assert found.size > 0.35


def test_duplicates(dataset, kick):
    turned = replace(kick, root_positions=kick.root_positions + np.array([3.0, 0.0, 1.0]))
    slower = replace(kick, frame_rate=30)
    moved = replace(
        kick, root_positions=kick.root_positions * [2.0, 1.0, 2.0] + np.linspace([0, 0, 0], [1, 0, 0], len(kick))
    )
    findings = check_motion([*dataset, turned, kick.mirrored("x"), slower, moved])
    found = {one.motion: one for one in findings if one.kind == "duplicate" and "motion 0" in one.what}
    assert [found[i].severity for i in (2, 3, 4, 5)] == ["warning", "warning", "error", "error"]
    assert "mirrored" in found[3].what
    assert "frame rate" in found[4].what
    assert "root" in found[5].what
    assert 1 not in found


def test_two_who_stand_still_are_not_mirror_images(kick):
    rng = np.random.default_rng(0)
    poses = rng.uniform(-0.3, 0.3, (2, 1, kick.skeleton.n_dofs)) + rng.normal(
        scale=1e-3, size=(2, 60, kick.skeleton.n_dofs)
    )
    findings = check_motion([replace(kick[:60], angles=angles) for angles in poses])
    assert not [one for one in findings if "duplicate" in one.kind]


def test_mixtures_and_motions_unlike_the_others(dataset):
    reach = make_actions(3, 4, actions=["reach"], rotations="file", random_state=1)
    strange = replace(dataset[0], angles=np.random.default_rng(0).uniform(-2, 2, dataset[0].angles.shape))
    findings = check_motion([*reach, strange, dataset[1].resample(30)])
    assert [one.motion for one in findings if one.kind == "unlike others"] == [12]
    assert [one.motion for one in findings if one.kind == "mixture"] == [13]


def test_other_things_than_motions_are_refused():
    with pytest.raises(TypeError, match="Motion"):
        check_motion([Keypoints(np.zeros((3, 2, 3)), ["a", "b"], 30)])


@pytest.mark.filterwarnings("ignore:c_centimetres.bvh")
def test_the_command(dataset, kick, tmp_path, capsys):
    save_bvh(tmp_path / "a_kick.bvh", kick, scale=1.0)
    save_bvh(tmp_path / "b_twice.bvh", kick, scale=1.0)
    save_bvh(tmp_path / "c_centimetres.bvh", dataset[1], scale=0.01)
    (tmp_path / "d_broken.bvh").write_text("HIERARCHY\n")
    assert main(["check", str(tmp_path), "--out", str(tmp_path / "report.csv")]) == 3
    text = capsys.readouterr().out
    assert "duplicate: it has the poses of a_kick.bvh" in text
    rows = list(csv.DictReader((tmp_path / "report.csv").read_text(encoding="utf-8").splitlines()))
    found = {(row["file"], row["kind"]) for row in rows}
    assert {("b_twice.bvh", "duplicate"), ("c_centimetres.bvh", "units"), ("d_broken.bvh", "reading")} <= found
    assert not any(name == "a_kick.bvh" for name, _ in found)
    assert main(["check", str(tmp_path), "--out", str(tmp_path / "report.html")]) == 3
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count("<li") == len(rows)
    assert 'id="finding-0"' not in page  # it cannot be read, so it is not played
    assert 'href="#finding=1' in page
