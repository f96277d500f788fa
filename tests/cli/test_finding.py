"""`skpose find`: without the query's own places, with one place a file, and for a single pose."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from skpose import pose_distances
from skpose._cli.finding import find_minima
from skpose._cli.main import main
from skpose.datasets import make_gait
from skpose.io import load_bvh, save_bvh
from skpose.motions import find_motion

FILES = ["a.bvh", "b.bvh", "c.bvh"]
RATE = 20


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Files of three motions of one person."""
    monkeypatch.chdir(tmp_path)
    gait = make_gait(n_subjects=1, n_sequences=2, duration=3.0, frame_rate=RATE, random_state=0)
    for name, motion, n_frames in zip(FILES, gait.motions[1:], (60, 44, 57), strict=True):
        save_bvh(name, motion[:n_frames], scale=1.0)
    return tmp_path


@pytest.fixture
def motions():
    return [load_bvh(name, scale=1.0) for name in FILES]


def rows(arguments, capsys):
    assert main(["find", *arguments]) == 0
    return [line.split() for line in capsys.readouterr().out.splitlines()[1:]]


def error(arguments, capsys, status=1):
    if status == 2:
        with pytest.raises(SystemExit):
            main(["find", *arguments])
    else:
        assert main(["find", *arguments]) == status
    return capsys.readouterr().err.splitlines()[-1]


QUERY = ["a.bvh", *FILES, "--from", "0.5", "--to", "1.0"]


def test_the_query_is_left_out_of_its_own_results(motions, capsys):
    query = motions[0][10:20]
    parts = [motions[0][:10], motions[0][20:], *motions[1:]]
    expected = find_motion(query, parts, k=6)
    names, firsts = ["a.bvh", *FILES], [0, 20, 0, 0]
    assert rows([*QUERY, "--k", "6", "--exclude-query"], capsys) == [
        [
            str(rank),
            names[part],
            f"{(firsts[part] + start) / RATE:.2f}",
            f"{(firsts[part] + stop) / RATE:.2f}",
            f"{distance:.4f}",
        ]
        for rank, (part, start, stop, distance) in enumerate(expected, start=1)
    ]
    assert rows(QUERY, capsys)[0][1:] == ["a.bvh", "0.50", "1.00", "0.0000"]


def test_the_same_file_under_another_name_is_the_query_too(folder, capsys):
    own = str(Path(folder, "a.bvh"))
    assert {row[1] for row in rows(["a.bvh", own, "b.bvh", "--exclude-query"], capsys)} == {"b.bvh"}
    shutil.copy("a.bvh", "copy.bvh")  # which is another file
    assert rows(["a.bvh", "copy.bvh", "b.bvh", "--exclude-query"], capsys)[0][1] == "copy.bvh"


def test_no_place_is_left(capsys):
    message = error(["a.bvh", "a.bvh", "--exclude-query"], capsys)
    assert message == "skpose: no place is left without --exclude-query: all frames of the files are those of a.bvh"


@pytest.mark.parametrize("options", [[], ["--exclude-query"]])
def test_one_place_of_each_file(options, capsys):
    found = rows([*QUERY, "--one-per-file", *options], capsys)
    every = rows([*QUERY, "--k", "100", *options], capsys)
    assert sorted(row[1] for row in found) == FILES
    for row in found:  # the first of those of its file
        assert row[1:] == next(one[1:] for one in every if one[1] == row[1])
    assert [float(row[-1]) for row in found] == sorted(float(row[-1]) for row in found)
    assert rows([*QUERY, "--one-per-file", "--k", "2", *options], capsys) == found[:2]


def test_short_places_are_said_to_be_short(motions, capsys):
    """Time warps freely: what is not like the query has it in a few frames."""
    query, options = motions[0][10:20], ["--exclude-query", "--k", "20"]
    places = find_motion(query, [motions[0][:10], motions[0][20:], *motions[1:]], k=20)
    short = sum(place.stop - place.start < len(query) / 2 for place in places)
    assert main(["find", *QUERY, *options]) == 0
    line = capsys.readouterr().err.splitlines()[-1]
    assert 0 < short < len(places)
    assert line == (
        f"skpose: {short} of {len(places)} places last less than half as long as the motion to find, 0.50 s, and have "
        "little of it"
    )
    assert main(["find", *QUERY, "--k", "1"]) == 0
    assert "less than half" not in capsys.readouterr().err


def test_how_files_are_retargeted_is_said_once_and_not_in_the_table(capsys):
    assert main(["find", *QUERY, "--k", "1", "--retarget", "auto"]) == 0
    printed = capsys.readouterr()
    assert printed.err.splitlines()[0] == "skpose: 4 of 4 files: by same numbers"
    assert len(printed.out.splitlines()) == 2


# A single pose


def minima_of(distances, reach):
    """Return the frames to which none within reach is nearer, slowly."""
    return [
        i for i in range(len(distances)) if distances[i] == distances[max(0, i - reach) : i + reach + 1].min()
    ]  # fmt: skip


@pytest.mark.parametrize("metric", ["spatial", "rotation"])
def test_a_pose(metric, motions, capsys):
    title = ["rank", "file", "time,", "s", "distance,", "m"]
    assert main(["find", "a.bvh", *FILES, "--pose", "0.73", "--k", "100", "--metric", metric]) == 0
    first, *lines = capsys.readouterr().out.splitlines()
    assert first.split() == title
    expected = []
    for name, motion in zip(FILES, motions, strict=True):
        query = motions[0].angles[15:16]  # of 0.75 s, the frame nearest to 0.73 s
        (D,) = pose_distances(query, motion.angles, skeleton=motion.skeleton, metric=metric)
        expected += [[name, f"{i / RATE:.2f}", f"{D[i]:.4f}"] for i in minima_of(D, 10)]
    expected.sort(key=lambda row: float(row[2]))
    assert [line.split()[1:] for line in lines] == expected
    assert expected[0] == ["a.bvh", "0.75", "0.0000"]
    others = rows(["a.bvh", *FILES, "--pose", "0.75", "--k", "100", "--metric", metric, "--exclude-query"], capsys)
    assert [row[1:] for row in others] == expected[1:]
    best = rows(["a.bvh", *FILES, "--pose", "0.75", "--metric", metric, "--one-per-file"], capsys)
    assert sorted(row[1] for row in best) == FILES


def test_minima_of_frames_with_gaps_and_of_still_people():
    distances = np.array([3.0, 1.0, 1.0, 1.0, 2.0, 0.5, 5.0, 5.0, 5.0])
    assert find_minima(distances, np.arange(9), 4.0).tolist() == [1, 5, 8]  # two frames in half a second
    assert find_minima(np.zeros(7), np.arange(7), 4.0).tolist() == [0, 3, 6]
    numbers = np.array([0, 1, 2, 3, 4, 20, 21, 22, 23])
    assert find_minima(distances, numbers, 4.0).tolist() == [1, 5, 8]
    assert find_minima(distances[:2], np.array([0, 9]), 4.0).tolist() == [0, 1]
    assert find_minima(distances, np.arange(9), 1.0).tolist() == list(range(9))  # a second is longer than that


@pytest.mark.parametrize(
    ("options", "status", "message"),
    [
        (["--pose", "3.1"], 1, "a.bvh lasts 3.00 s: choose another time than --pose 3.1"),
        (["--pose", "-1"], 2, "argument --pose: expected a time in seconds, zero or more, got '-1'"),
        (["--pose", "1", "--to", "2"], 2, "--pose is a single pose, and --from and --to are for a motion"),
        (["--pose", "1", "--from", "0"], 2, "--pose is a single pose, and --from and --to are for a motion"),
    ],
    ids=str,
)
def test_errors(options, status, message, capsys):
    assert message in error(["a.bvh", "b.bvh", *options], capsys, status)
