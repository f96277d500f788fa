"""Whole motions on the command line: `skpose motions` and `skpose find`."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from skpose import Skeleton, motion_distances
from skpose._cli.main import main
from skpose._parallel.checkpoint import IDENTITY, FileCheckpoint
from skpose.datasets import make_gait
from skpose.io import load_bvh, save_bvh
from skpose.motions import MotionMatch, find_motion

FILES = ["a.bvh", "b.bvh", "c.bvh"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Files of three motions of different lengths, on skeletons of two people."""
    monkeypatch.chdir(tmp_path)
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=20, random_state=0)
    for name, motion, n_frames in zip(FILES, gait.motions[1:], (20, 14, 17), strict=True):
        save_bvh(name, motion[:n_frames], scale=1.0)
    return tmp_path


@pytest.fixture
def motions():
    return [load_bvh(name, scale=1.0) for name in FILES]


def refusal(arguments, capsys, status=1):
    """Run a command that must fail; return its last line on stderr."""
    if status == 2:
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        assert stop.value.code == 2
    else:
        assert main(arguments) == status
    return capsys.readouterr().err.splitlines()[-1]


# --- skpose motions --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "parameters"),
    [
        ([], {"metric": "spatial"}),
        (["--metric", "position", "--window", "0.1"], {"metric": "position", "window": 0.1}),
        (["--alignment", "subsequence", "--jobs", "1"], {"metric": "spatial", "alignment": "subsequence"}),
    ],
    ids=str,
)
def test_motions(motions, options, parameters, capsys):
    assert main(["motions", *FILES, "--out", "D.npy", *options]) == 0
    np.testing.assert_array_equal(np.load("D.npy"), motion_distances(motions, **parameters))
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines[:3]] == [
        [str(row), str(len(motion)), "frames", name]
        for row, (name, motion) in enumerate(zip(FILES, motions, strict=True))
    ]
    assert lines[3] == "D.npy: 3 × 3 distances, float64"
    assert sorted(os.listdir()) == ["D.npy", *FILES]


def test_motions_in_float32_and_at_another_rate(motions):
    assert main(["motions", ".", "--frame-rate", "10", "--dtype", "float32", "--out", "D.npy"]) == 0
    arrays = [motion.resample(10).angles.astype(np.float32) for motion in motions]
    skeleton = Skeleton.mean({motion.skeleton: None for motion in motions})
    D = np.load("D.npy")
    assert D.dtype == np.float32
    np.testing.assert_array_equal(D, motion_distances(arrays, skeleton=skeleton))


def test_motions_frame_by_frame(motions, capsys):
    for name, motion in zip(FILES, motions, strict=True):
        save_bvh(f"short_{name}", motion[:10], scale=1.0)
    short = [f"short_{name}" for name in FILES]
    assert main(["motions", *short, "--alignment", "frames", "--out", "D.npy"]) == 0
    expected = motion_distances([motion[:10] for motion in motions], metric="spatial", alignment="frames")
    np.testing.assert_allclose(np.load("D.npy"), expected, atol=1e-6)  # files have six digits
    line = refusal(["motions", *FILES, "--alignment", "frames", "--out", "E.npy"], capsys)
    assert (
        "motions of equal length, but a.bvh has 20 frames and b.bvh 14: resample them, or take --alignment dtw" in line
    )
    assert not Path("E.npy").exists()


@pytest.mark.slow
def test_motions_on_other_processes(motions):
    assert main(["motions", *FILES, "--backend", "loky", "--jobs", "2", "--out", "D.npy"]) == 0
    np.testing.assert_array_equal(np.load("D.npy"), motion_distances(motions))


def test_an_interrupted_matrix_of_motions_is_continued(motions, capsys, monkeypatch):
    def interrupted(*_, out, **__):
        FileCheckpoint(Path("D.npy")).start({IDENTITY: "of these motions"}, [])
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("skpose._cli.commands.motion_distances", interrupted)
        assert main(["motions", *FILES, "--out", "D.npy"]) == 130
    assert capsys.readouterr().err.splitlines()[-1] == "skpose: interrupted; run the same command again to continue"
    assert Path("D.npy").exists()

    def finished(arrays, out, **_):
        out[:] = 1.0

    monkeypatch.setattr("skpose._cli.commands.motion_distances", finished)
    assert main(["motions", *FILES, "--out", "D.npy"]) == 0
    assert "D.npy is unfinished: continuing" in capsys.readouterr().out
    assert refusal(["motions", *FILES[:2], "--out", "D.npy"], capsys).startswith(
        "skpose: D.npy is an unfinished matrix"
    )


def test_motions_of_different_rates_are_refused_by_file(motions, capsys):
    save_bvh("fast.bvh", replace(motions[0], frame_rate=40.0), scale=1.0)
    for command in (["motions", *FILES, "fast.bvh", "--out", "D.npy"], ["find", "a.bvh", "fast.bvh"]):
        line = refusal(command, capsys)
        assert line.startswith("skpose: a.bvh has 20 frames a second and fast.bvh 40, which changes the distances:")
        assert line.endswith("resample all with --frame-rate, such as --frame-rate 20")
    assert main(["motions", *FILES, "fast.bvh", "--frame-rate", "20", "--out", "D.npy"]) == 0
    save_bvh("digits.bvh", replace(motions[0], frame_rate=20.0005), scale=1.0)  # as a file that writes fewer digits
    assert main(["motions", *FILES, "digits.bvh", "--out", "E.npy"]) == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--window", "1.5"], "argument --window: invalid share from 0 to 1 value: '1.5'"),
        (["--window", "0.1", "--alignment", "subsequence"], "--window is the band of --alignment dtw, not subsequence"),
        (["--alignment", "warp"], "argument --alignment: invalid choice"),
    ],
    ids=str,
)
def test_options_of_motions_are_checked(options, message, capsys):
    assert message in refusal(["motions", *FILES, "--out", "D.npy", *options], capsys, status=2)


# --- skpose find -----------------------------------------------------------------------------------------------------


@pytest.fixture
def calls(monkeypatch):
    """Arguments of `find_motion`, in the place of which a stand-in answers."""
    found = []

    def find_motion(query, motions, **options):
        found.append((query, motions, options))
        return [MotionMatch(1, 4, 8, 0.0123), MotionMatch(0, 0, 7, 1.5)]

    monkeypatch.setattr("skpose._cli.finding.find_motion", find_motion)
    return found


def test_find_prints_the_best_places(motions, calls, capsys):
    assert main(["find", "a.bvh", "b.bvh", "c.bvh", "--k", "2", "--jobs", "1"]) == 0
    title, *rows = capsys.readouterr().out.splitlines()
    assert title.split() == ["rank", "file", "start,", "s", "end,", "s", "distance,", "m"]
    assert [row.split() for row in rows] == [
        ["1", "c.bvh", "0.20", "0.40", "0.0123"],
        ["2", "b.bvh", "0.00", "0.35", "1.5000"],
    ]
    assert len({len(line) for line in (title, *rows)}) == 1
    ((query, recordings, options),) = calls
    skeleton = Skeleton.mean({motion.skeleton: None for motion in motions})
    assert {motion.skeleton for motion in (query, *recordings)} == {options["skeleton"]} == {skeleton}
    np.testing.assert_array_equal(query.angles, motions[0].angles)
    for recording, motion in zip(recordings, motions[1:], strict=True):
        np.testing.assert_array_equal(recording.angles, motion.angles)
    assert (options["k"], options["metric"], options["n_jobs"]) == (2, "spatial", 1)


@pytest.mark.parametrize("options", [[], ["--metric", "position", "--k", "3"], ["--metric", "angle", "--jobs", "2"]])
def test_places_are_those_of_find_motion(motions, options, capsys):
    assert main(["find", "b.bvh", *FILES, "--from", "0.2", "--to", "0.5", *options]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[1:]]
    metric, k = options[1] if options else "spatial", 3 if "--k" in options else 10
    found = find_motion(motions[1][4:10], motions, k=k, metric=metric)
    assert rows == [
        [str(rank), FILES[i], f"{start / 20:.2f}", f"{stop / 20:.2f}", f"{distance:.4f}"]
        for rank, (i, start, stop, distance) in enumerate(found, start=1)
    ]
    assert rows[0] == ["1", "b.bvh", "0.20", "0.50", "0.0000"]


def test_find_a_part_of_a_file(motions, calls, capsys):
    assert main(["find", "a.bvh", *FILES[1:], "--from", "0.1", "--to", "0.5", "--metric", "angle"]) == 0
    np.testing.assert_array_equal(calls[-1][0].angles, motions[0].angles[2:10])
    assert calls[-1][2]["metric"] == "angle"
    assert calls[-1][2]["k"] == 10
    assert capsys.readouterr().out.splitlines()[0].endswith("distance, rad")
    assert main(["find", "a.bvh", *FILES[1:], "--from", "0.3", "--to", "0.31"]) == 0
    np.testing.assert_array_equal(calls[-1][0].angles, motions[0].angles[6:7])
    assert main(["find", "a.bvh", *FILES[1:], "--from", "0.5", "--frame-rate", "10"]) == 0
    np.testing.assert_array_equal(calls[-1][0].angles, motions[0].resample(10).angles[5:])
    assert calls[-1][1][0].frame_rate == 10


@pytest.mark.usefixtures("calls")
@pytest.mark.filterwarnings("ignore:c.bvh. 1 of 17 frames:UserWarning")
def test_times_are_those_of_the_file(capsys):
    """A file whose frames with NaN were left out keeps the times of the others."""
    lines = Path("c.bvh").read_text().splitlines()
    lines[-16] = lines[-16].replace(lines[-16].split()[0], "nan", 1)  # the second frame of 17
    Path("c.bvh").write_text("\n".join(lines))
    assert main(["find", "a.bvh", *FILES[1:], "--on-nan", "drop"]) == 0
    assert capsys.readouterr().out.splitlines()[1].split() == ["1", "c.bvh", "0.25", "0.45", "0.0123"]


@pytest.mark.usefixtures("calls")
@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (
            ["a.bvh", "b.bvh", "--from", "2"],
            1,
            "a.bvh has no frame from 2 s on, as it lasts 1.00 s: choose other times",
        ),
        (
            ["a.bvh", "b.bvh", "--from", "0.31", "--to", "0.32"],
            1,
            "a.bvh has no frame from 0.31 s on and before 0.32 s",
        ),
        (["a.bvh", "b.bvh", "--from", "0.5", "--to", "0.5"], 2, "--to 0.5 must be after --from 0.5"),
        (["a.bvh", "b.bvh", "--from", "-1"], 2, "argument --from: expected a time in seconds, zero or more, got '-1'"),
        (["a.bvh"], 2, "the following arguments are required: FILE"),
        (["a.bvh", "b.bvh", "--k", "0"], 2, "argument --k: invalid positive integer"),
        ([".", "b.bvh"], 1, "QUERY must be one file, and . is a folder: choose a file in it"),
        (["none.bvh", "b.bvh"], 1, "none.bvh"),
    ],
    ids=str,
)
def test_errors_of_find(arguments, status, message, capsys):
    assert message in refusal(["find", *arguments], capsys, status)
