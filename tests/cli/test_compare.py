"""`skpose compare`: the numbers in its table, and its errors."""

import subprocess
import sys

import numpy as np
import pytest

import skpose
from skpose import SpatialMDS, pose_distances
from skpose._cli.compare import COMPARED, FRAME_RATE, compare
from skpose._cli.main import main
from skpose.datasets import MotionDataset, make_gait, walks_and_runs


@pytest.fixture(scope="module")
def gait():
    return make_gait(n_subjects=2, n_sequences=2, duration=1.0, random_state=0)


@pytest.fixture(scope="module")
def rows(gait):
    return list(compare(gait))


def test_the_generated_motions_are_twenty_walks_and_twenty_runs_of_five_people():
    """Those of `skpose compare` without a folder, as docs/results.md describes its figures."""
    gait = walks_and_runs(make_gait(random_state=0))
    assert {name: int((gait.actions == name).sum()) for name in ("walk", "run")} == {"walk": 20, "run": 20}
    assert len(set(gait.subjects)) == 5


def test_accuracies_are_those_of_the_nearest_neighbour_in_other_groups(gait, rows):
    X, sequence = gait.poses(FRAME_RATE)
    y = gait.actions[sequence]
    assert [row.metric for row in rows] == list(COMPARED)
    for row in rows:
        D = pose_distances(X, skeleton=gait.skeleton, metric=row.metric)
        for accuracy, groups in (
            (row.leave_sequence_out, sequence),
            (row.leave_subject_out, gait.subjects[sequence]),
        ):
            in_other_groups = np.where(groups[:, None] == groups, np.inf, D)
            assert accuracy == np.mean(y[in_other_groups.argmin(axis=1)] == y)
        shares = []
        for i in range(len(gait)):
            mds = SpatialMDS(gait.skeleton, n_components=1, metric=row.metric).fit(X[sequence == i])
            shares.append(mds.explained_variance_ratio_[0])
        np.testing.assert_allclose(row.first_component, np.median(shares))


def test_one_subject_cannot_be_left_out(gait):
    assert all(np.isnan(row.leave_subject_out) for row in compare(gait[gait.subjects == "01"]))


def test_walks_and_runs_are_chosen_by_their_first_word(gait):
    words = ["run/jog", "walk on uneven terrain", "Run", "jump, balance", "walking", "walk", "", "run"]
    dataset = MotionDataset(gait.motions, gait.subjects, gait.trials, words)
    assert list(walks_and_runs(dataset).actions) == ["run", "walk", "run", "walk", "run"]
    with pytest.raises(ValueError, match="none has an action that begins with 'run': write one line for each motion"):
        walks_and_runs(dataset[[1, 5]])


def test_command_line_prints_a_row_for_each_metric(gait, rows, monkeypatch, capsys):
    monkeypatch.setattr("skpose._cli.commands.make_gait", lambda random_state: {0: gait}[random_state])
    assert main(["compare", "--jobs", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for expected in rows:
        (row,) = (line.split() for line in lines if line.startswith(expected.metric))
        assert row[1] == f"{expected.leave_subject_out:.1%}"
        assert row[2] == f"{expected.leave_sequence_out:.1%}"
        assert f"{expected.first_component:.1%}" in row
        assert float(row[-2]) > 0  # seconds
    assert "4 walks, 4 runs, 2 subjects" in lines[1]
    last = max(i for i, line in enumerate(lines) if line.startswith(COMPARED))
    assert all(column in lines[last + 1] for column in ("Subject out:", "Seq. out:", "MDS:"))  # one line for all
    assert not lines[last + 2]


def test_command_line_on_real_files(cmu_folder, capsys):
    assert main(["compare", str(cmu_folder)]) == 0
    out = capsys.readouterr().out
    assert "28 walks, 12 runs, 5 subjects" in out
    rows = {line.split()[0]: line.split() for line in out.splitlines() if line.startswith(("angle", "spatial"))}
    assert rows["angle"][3] == "90%"
    assert rows["spatial"][1:4] == ["100.0%", "100.0%", "100%"]
    assert abs(float(rows["spatial"][4].rstrip("%")) - 80) < 5


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
