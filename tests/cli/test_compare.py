"""`skpose compare`: the numbers in its table, its picture, and its errors."""

import subprocess
import sys

import numpy as np
import pytest
from matplotlib.image import imread

import skpose
from skpose import Bone, Motion, Skeleton, SpatialMDS, forward_kinematics, motion_distances, pose_distances
from skpose._cli.compare import COMPARED, FRAME_RATE, choose_actions, compare, prepare, warp_all
from skpose._cli.main import main
from skpose._cli.picture import UPRIGHT, see
from skpose.datasets import MotionDataset, humanoid, make_actions, make_gait, walks_and_runs

NAME = "skpose._cli.commands.make_actions"


@pytest.fixture(scope="module")
def actions():
    return make_actions(2, 2, actions=["jump", "squat", "wave"], frame_rate=24, random_state=0)


@pytest.fixture(scope="module")
def rows(actions):
    return list(compare(prepare(actions)))


def printed(lines, metric):
    """Return the words of a row of the table."""
    (row,) = (line.split() for line in lines if line.startswith(metric))
    return row


def test_the_generated_motions_are_those_of_the_documentation():
    """Those of `skpose compare` without a folder, and of `--paper`, as docs/results.md describes its figures."""
    dataset = make_actions(random_state=0)
    assert (len(dataset), len(set(dataset.subjects)), len(set(dataset.actions))) == (180, 3, 10)
    gait = walks_and_runs(make_gait(random_state=0))
    assert {name: int((gait.actions == name).sum()) for name in ("walk", "run")} == {"walk": 20, "run": 20}
    assert len(set(gait.subjects)) == 5


@pytest.mark.parametrize("paper", [False, True])
def test_motions_are_on_ball_joints_unless_as_in_the_paper(actions, paper):
    gait = make_gait(2, 1, random_state=0)
    prepared = prepare(gait if paper else actions, paper=paper)
    assert any(bone.is_ball for bone in prepared.skeleton.bones) != paper
    assert {motion.frame_rate for motion in prepared} == {FRAME_RATE}


def test_accuracies_are_those_of_the_nearest_neighbour_in_other_groups(actions, rows):
    """By matrices, and by `motion_distances`."""
    dataset = prepare(actions)
    X, sequence = dataset.poses()
    assert [row.metric for row in rows] == list(COMPARED)
    for row in rows:
        D = pose_distances(X, skeleton=dataset.skeleton, metric=row.metric)
        M = motion_distances(dataset, skeleton=dataset.skeleton, metric=row.metric)
        for accuracy, distances, labels, groups in (
            (row.frames_of_others, D, dataset.actions[sequence], dataset.subjects[sequence]),
            (row.motions_of_others, M, dataset.actions, dataset.subjects),
            (row.frames, D, dataset.actions[sequence], sequence),
            (row.motions, M, dataset.actions, np.arange(len(dataset))),
        ):
            in_other_groups = np.where(groups[:, None] == groups, np.inf, distances)
            assert accuracy == np.mean(labels[in_other_groups.argmin(axis=1)] == labels)
        shares = []
        for i in range(len(dataset)):
            mds = SpatialMDS(dataset.skeleton, n_components=1, metric=row.metric).fit(X[sequence == i])
            shares.append(mds.explained_variance_ratio_[0])
        np.testing.assert_allclose(row.first_component, np.median(shares))


def test_distances_of_motions_are_those_of_motion_distances(actions):
    dataset = prepare(actions)
    X, sequence = dataset.poses()
    frames = [np.flatnonzero(sequence == i) for i in range(len(dataset))]
    D = pose_distances(X, skeleton=dataset.skeleton, metric="position")
    expected = motion_distances(dataset, skeleton=dataset.skeleton, metric="position")
    np.testing.assert_allclose(warp_all(D, frames), expected, rtol=1e-12)


def test_one_person_has_no_others(actions):
    for row in compare(prepare(actions[actions.subjects == "01"])):
        assert np.isnan([row.frames_of_others, row.motions_of_others]).all()
        assert row.motions >= 0


def test_actions_are_those_of_two_people(actions):
    words = np.array(actions.actions)
    words[:2], words[2] = "Jump", "leap"
    chosen = choose_actions(MotionDataset(actions.motions, actions.subjects, actions.trials, words))
    assert sorted(set(chosen.actions)) == ["jump", "squat", "wave"]  # upper and lower case are one
    assert len(chosen) == len(actions) - 1
    alone = actions[actions.subjects == "01"]
    words = np.array(alone.actions)
    words[0] = "leap"  # and jump once
    chosen = choose_actions(MotionDataset(alone.motions, alone.subjects, alone.trials, words))
    assert sorted(chosen.actions) == ["squat"] * 2 + ["wave"] * 2


def test_nothing_to_compare_is_said_in_words(actions):
    words = [f"{action} {subject}" for action, subject in zip(actions.actions, actions.subjects, strict=True)]
    dataset = MotionDataset(actions.motions, actions.subjects, actions.trials, words)
    message = "expected two actions that two people do, found none, and of one each 'jump 01', 'jump 02'"
    with pytest.raises(ValueError, match=message):
        choose_actions(dataset)
    words = np.where(actions.actions == "jump", "jump", words)
    with pytest.raises(ValueError, match="found 'jump' alone, and of one each 'squat 01'"):
        choose_actions(MotionDataset(actions.motions, actions.subjects, actions.trials, words))
    with pytest.raises(ValueError, match="expected two actions that are done twice, found none"):
        choose_actions(actions[[0, 2]])


def test_walks_and_runs_are_chosen_by_their_first_word():
    gait = make_gait(n_subjects=2, n_sequences=2, duration=1.0, random_state=0)
    words = ["run/jog", "walk on uneven terrain", "Run", "jump, balance", "walking", "walk", "", "run"]
    dataset = MotionDataset(gait.motions, gait.subjects, gait.trials, words)
    assert list(walks_and_runs(dataset).actions) == ["run", "walk", "run", "walk", "run"]
    with pytest.raises(ValueError, match="none has an action that begins with 'run': write one line for each motion"):
        walks_and_runs(dataset[[1, 5]])


def test_command_line_prints_a_row_for_each_metric(actions, rows, monkeypatch, capsys):
    monkeypatch.setattr(NAME, lambda random_state: {0: actions}[random_state])
    assert main(["compare", "--jobs", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    n_poses = sum(map(len, prepare(actions)))
    assert lines[1] == f"12 motions of 3 actions by 2 people, {n_poses} poses at 12 Hz, ball joints"
    for expected in rows:
        row = printed(lines, expected.metric)
        assert row[1:6] == [f"{share:.1%}" for share in expected[1:6]]
        assert float(row[-2]) > 0  # seconds
    assert "Paper" not in "".join(lines)


def test_command_line_draws_a_picture(actions, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(NAME, lambda random_state: actions)
    out = tmp_path / "compared.png"
    assert main(["compare", "--out", str(out), "--jobs", "1"]) == 0
    assert str(out) in capsys.readouterr().out
    picture = imread(out)
    assert min(picture.shape[:2]) > 500
    assert np.ptp(picture[..., :3]) == 1  # black and white at least
    assert main(["compare", "--out", str(out)]) == 1
    assert "already exists" in capsys.readouterr().err
    monkeypatch.setattr("skpose._cli.commands.find_spec", lambda name: None)
    assert main(["compare", "--out", str(tmp_path / "other.png")]) == 1
    assert capsys.readouterr().err == "skpose: the picture needs matplotlib: pip install 'skpose[plot]'\n"
    with pytest.raises(SystemExit):
        main(["compare", "--out", "compared.txt"])
    assert "does not end in .png" in capsys.readouterr().err


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_people_in_pictures_stand_upright(up):
    """In a world whose other axis points up, they look the same."""
    skeleton, turn = humanoid(), UPRIGHT[up].T
    pose = forward_kinematics(np.random.default_rng(0).normal(size=(1, skeleton.n_dofs)) / 3, skeleton)[0]
    parents = np.concatenate([pose, np.zeros((1, 3))])[skeleton.parents]
    bones = [
        Bone(bone.name, bone.parent, turn @ (end - start), "x" if bone.name == "head" else "")
        for bone, start, end in zip(skeleton.bones, parents, pose, strict=True)
    ]
    rigid = Skeleton(bones)
    found, side = see(Motion(rigid, np.zeros((1, 1)), 12.0, up=up), 0)
    assert found[..., 1].min() == 0.0
    np.testing.assert_allclose(np.ptp(found[..., 1]), np.ptp(np.append(pose[:, 1], 0.0)))
    head = found[1 + rigid.joint_names.index("head"), 0]  # behind the root
    np.testing.assert_allclose(head[1], pose[skeleton.joint_names.index("head"), 1] - min(pose[:, 1].min(), 0.0))
    assert set(side) == {"", "left", "right"}


def test_the_papers_protocol_on_real_files(cmu_folder, capsys):
    assert main(["compare", str(cmu_folder), "--paper"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1] == "40 motions of 2 actions by 5 people, 1,363 poses at 12 Hz, angles as they are"
    assert printed(lines, "angle")[1:6] == ["99.1%", "100.0%", "100.0%", "100.0%", "40.0%"]
    assert printed(lines, "spatial")[1:6] == ["100.0%", "100.0%", "100.0%", "100.0%", "81.8%"]
    assert "angle 90 %, spatial 100 %" in " ".join(lines)


@pytest.mark.slow
def test_actions_of_real_files(hdm05_folder, capsys):
    """As docs/metrics.md has them by other functions."""
    assert main(["compare", str(hdm05_folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("188 motions of 11 actions by 3 people")
    expected = {"angle": (50.3, 81.4), "position": (67.4, 98.4), "rotation": (58.9, 94.7), "spatial": (67.3, 97.9)}
    for metric, shares in expected.items():
        assert [float(cell.rstrip("%")) for cell in printed(lines, metric)[1:3]] == list(shares)


def test_errors_are_one_line_on_stderr(tmp_path, capsys):
    assert main(["compare", str(tmp_path / "nowhere")]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("skpose: ")
    assert captured.err.count("\n") == 1
    with pytest.raises(SystemExit) as stop:
        main(["walk"])
    assert stop.value.code == 2


def test_runs_as_a_module():
    done = subprocess.run([sys.executable, "-m", "skpose", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == f"skpose {skpose.__version__}"
