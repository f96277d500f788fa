"""Files of a command: frame rates from an index, files that are left out, warnings of one kind, scales by the size."""

import gzip
import json
import os
import re
import shutil
import subprocess
import sys
import warnings
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from skpose import Bone, Motion, Skeleton, pose_distances
from skpose._cli.main import main
from skpose._cli.messages import Note, count_files, group
from skpose.datasets import load_cmu, make_gait
from skpose.io import _opening, load_bvh, save_bvh

HEAD = "subject,trial,action,frames_per_second,file"
POSITION = "--metric", "position"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def cmu():
    """A folder as that of CMU: an index above the files, one of which is at 30 Hz."""
    for name in ("01", "35"):
        Path("cmu", "subjects", name).mkdir(parents=True)
        shutil.copy(DATA / "arm.asf", f"cmu/subjects/{name}/{name}.asf")
        shutil.copy(DATA / "arm.amc", f"cmu/subjects/{name}/{name}_01.amc")
    rows = [HEAD, "01,01,wave,120,subjects/01/01_01.amc", "35,01,wave,30,subjects/35/35_01.amc"]
    Path("cmu/index.csv").write_text("\n".join(rows))
    return ["cmu/subjects/01/01_01.amc", "cmu/subjects/35/35_01.amc"]


@pytest.fixture
def gait():
    """Two good files with two bad ones between them, in a folder."""
    Path("takes").mkdir()
    dataset = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=20, random_state=0)
    for name, motion in zip("ad", dataset, strict=False):
        save_bvh(f"takes/{name}.bvh", motion, scale=1.0)
    text = Path("takes/a.bvh").read_text()
    Path("takes/b.bvh").write_text(text[: len(text) // 3])
    Path("takes/c.bvh").write_text("hello")
    return [Path("takes/a.bvh"), Path("takes/d.bvh")]


@contextmanager
def shown_warnings():
    """Warnings as a user has them, not as errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        yield


def run(*arguments):
    with shown_warnings():
        return main([str(argument) for argument in arguments])


def lines(text):
    return [line.removeprefix("skpose: ") for line in text.splitlines()]


# Frame rates of AMC files


def test_info_states_the_rate_of_an_index_above_the_file(cmu, capsys):
    assert main(["info", *cmu]) == 0
    out = capsys.readouterr().out
    assert "3 frames at 120 Hz by index.csv, 0.03 s" in out
    assert "3 frames at 30 Hz by index.csv, 0.10 s" in out


@pytest.mark.parametrize("where", ["cmu", "cmu/subjects/35", "cmu/subjects/35/35_01.amc"])
def test_distances_and_neighbors_are_those_of_load_cmu(cmu, where):
    """A folder, one below that of the index, and a single file; each at the rate of the index."""
    dataset = load_cmu("cmu")
    X = [motion.resample(30).angles for motion in (dataset if where == "cmu" else [dataset.motions[1]])]
    assert [len(x) for x in X] == ([1, 3] if where == "cmu" else [3])  # at 120 Hz there is one pose, at 30 Hz three
    assert main(["distances", where, *POSITION, "--frame-rate", "30", "--out", "D.npy"]) == 0
    expected = pose_distances(np.concatenate(X), skeleton=dataset.skeleton, metric="position")
    np.testing.assert_allclose(np.load("D.npy"), expected, atol=1e-12)
    command = ["neighbors", where, *POSITION, "--frame-rate", "30", "--neighbors", "1", "--out", "G.npz"]
    assert main(command) == 0


def test_view_plays_at_the_rate_of_the_index(cmu):
    assert main(["view", *cmu, "--out", "view.html"]) == 0
    text = Path("view.html").read_text(encoding="utf-8")
    motions = json.loads(re.findall(r'id="data">(.*?)</script>', text, flags=re.S)[0])["motions"]
    assert [motion["rate"] for motion in motions] == [120, 30]


def test_motions_and_find_compare_at_the_rates_of_the_index(cmu, capsys):
    assert main(["motions", *cmu, *POSITION, "--out", "M.npy"]) == 1
    assert "has 120 frames a second and cmu/subjects/35/35_01.amc 30" in capsys.readouterr().err.replace("\\", "/")
    assert main(["find", cmu[1], cmu[1], *POSITION, "--k", "1"]) == 0
    assert capsys.readouterr().out.splitlines()[1].split()[2:4] == ["0.00", "0.10"]  # start and end, s


def test_a_link_to_a_file_of_an_index_has_its_rate(cmu, capsys):
    os.symlink(Path(cmu[1]).absolute(), "link.amc")
    assert main(["info", "link.amc"]) == 0
    assert "3 frames at 30 Hz by index.csv" in capsys.readouterr().out


def test_the_option_replaces_the_rate_of_the_index_and_says_so(cmu, capsys):
    assert run("info", *cmu, "--amc-frame-rate", "120") == 0
    captured = capsys.readouterr()
    assert captured.out.count("3 frames at 120 Hz, 0.03 s") == 2
    (line,) = lines(captured.err)
    assert line == f"warning: {cmu[1]}: --amc-frame-rate 120 replaces the 30 Hz that index.csv states"


def test_an_index_of_another_program_is_none(cmu, capsys):
    for text in ("name,size\na,1\n", "", "\0\xff", "file,action\nsubjects/35/35_01.amc,walk\n"):
        Path("cmu/index.csv").write_text(text, encoding="latin-1")
        assert run("info", cmu[1]) == 0
        captured = capsys.readouterr()
        assert "3 frames at 120 Hz, 0.03 s" in captured.out
        assert "warning: AMC files do not state their frame rate: 120 Hz is taken" in captured.err
    Path("cmu/index.csv").write_text(f"{HEAD}\n35,01,wave,often,subjects/35/35_01.amc")
    assert main(["info", cmu[1]]) == 1  # but one of ours that is damaged is an error
    assert "frames_per_second: expected a positive number, found 'often'" in capsys.readouterr().err


def test_a_blank_rate_is_none(cmu, capsys):
    Path("cmu/index.csv").write_text(f"{HEAD}\n35,01,wave,,subjects/35/35_01.amc")
    assert run("info", cmu[1]) == 0
    assert "120 Hz is taken" in capsys.readouterr().err


def test_the_assumed_rate_is_said_once_for_many_files(cmu, capsys):
    Path("cmu/index.csv").unlink()
    assert run("distances", "cmu", *POSITION, "--out", "D.npy") == 0
    (line,) = [line for line in lines(capsys.readouterr().err) if "Hz" in line]
    assert line == (
        "warning: in all 2 files: AMC files do not state their frame rate: 120 Hz is taken, the usual rate of CMU and "
        "HDM05; pass --amc-frame-rate, in Hz"
    )


def test_a_name_as_in_hdm05_states_the_rate(capsys):
    shutil.copy(DATA / "arm.asf", "HDM_bd.asf")
    shutil.copy(DATA / "arm.amc", "HDM_bd_squat1Reps_001_060.amc")
    assert main(["info", "HDM_bd_squat1Reps_001_060.amc"]) == 0
    assert "3 frames at 60 Hz by its name" in capsys.readouterr().out


# Files that cannot be read


def test_bad_files_are_left_out_and_named(gait, capsys):
    assert run("distances", "takes", *POSITION, "--out", "D.npy", "--skip-errors") == 3
    captured = capsys.readouterr()
    motions = [load_bvh(path) for path in gait]
    X, skeleton = np.concatenate([m.angles for m in motions]), Skeleton.mean([m.skeleton for m in motions])
    np.testing.assert_allclose(np.load("D.npy"), pose_distances(X, skeleton=skeleton, metric="position"), atol=1e-12)
    assert [line.split()[-1] for line in captured.out.splitlines()[:2]] == [str(path) for path in gait]
    *_, count, first, second = lines(captured.err)
    assert count == "2 of 4 files left out:"
    assert first.startswith(f"  {Path('takes/b.bvh')}, line ")
    assert second.startswith(f"  {Path('takes/c.bvh')}: this is not a motion file")


def test_without_the_option_the_first_bad_file_is_an_error_that_names_it(gait, capsys):
    assert run("distances", "takes", *POSITION, "--out", "D.npy") == 1
    line = lines(capsys.readouterr().err)[-1]
    assert line.startswith(f"{Path('takes/b.bvh')}, line ")
    assert line.endswith("; --skip-errors leaves out such files")
    assert not Path("D.npy").exists()
    assert run("info", "takes/c.bvh") == 1
    assert "--skip-errors" not in capsys.readouterr().err  # of a single file there is nothing left


@pytest.mark.parametrize(
    "command",
    [
        ["info"],
        ["view", "--out", "out.html"],
        ["neighbors", *POSITION, "--neighbors", "1", "--out", "out.npz"],
        ["motions", *POSITION, "--out", "out.npy"],
        ["explore", *POSITION, "--out", "out.html"],
    ],
)
def test_every_command_leaves_out_bad_files(gait, capsys, command):
    assert run(command[0], "takes", "none.bvh", *command[1:], "--skip-errors") == 3
    assert lines(capsys.readouterr().err)[-4] == "3 of 5 files left out:"
    assert run(command[0], *gait, *(word.replace("out.", "new.") for word in command[1:]), "--skip-errors") == 0
    assert "left out" not in capsys.readouterr().err


def test_the_labels_of_a_page_are_those_of_the_files_that_are_read(gait, capsys):
    for old, new in zip("abcd", ("anna_walk_1", "anna_walk_2", "ben_run_1", "ben_run_2"), strict=True):
        Path(f"takes/{old}.bvh").rename(f"takes/{new}.bvh")
    assert run("explore", "takes", *POSITION, "--out", "page.html", "--skip-errors") == 3
    text = Path("page.html").read_text(encoding="utf-8")
    data = json.loads(re.findall(r'id="data">(.*?)</script>', text, flags=re.S)[0])
    assert data["labels"] == ["anna · walk · 1", "ben · run · 2"]


def test_the_motion_to_find_is_never_left_out(gait, capsys):
    assert run("find", "takes/c.bvh", *gait, *POSITION, "--skip-errors") == 1
    assert lines(capsys.readouterr().err)[-1].startswith(f"{Path('takes/c.bvh')}: this is not a motion file")
    assert run("find", gait[0], "takes", *POSITION, "--k", "1", "--skip-errors") == 3
    assert str(gait[0]) in capsys.readouterr().out


def test_where_no_file_can_be_read_it_is_an_error(gait, capsys):
    assert run("view", "takes/b.bvh", "takes/c.bvh", "--out", "view.html", "--skip-errors") == 1
    count, _, _, error = lines(capsys.readouterr().err)
    assert (count, error) == ("2 of 2 files left out:", "no file can be read")
    assert not Path("view.html").exists()


def test_a_motion_without_frames_is_left_out_where_frames_are_needed(gait, capsys):
    text = gait[0].read_text()
    Path("takes/b.bvh").write_text(f"{text[: text.index('Frames:')]}Frames: 0\nFrame Time: 0.05\n")
    Path("takes/c.bvh").unlink()
    assert run("view", "takes", "--out", "view.html", "--skip-errors") == 3
    assert lines(capsys.readouterr().err)[-1] == f"  {Path('takes/b.bvh')} has no frames"


def test_an_error_of_the_skeleton_names_both_files(cmu, capsys):
    Path("cmu/subjects/35/35.asf").write_text("hello")
    assert run("info", *cmu, "--skip-errors") == 3
    asf = Path("cmu/subjects/35/35.asf")
    assert lines(capsys.readouterr().err)[-1].startswith(f"  {cmu[1]}: {asf}, line 1, column 1: expected a keyword")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_pipes_links_and_folders_with_the_names_of_files(gait, capsys, monkeypatch):
    monkeypatch.setattr(_opening, "PATIENCE", 0.1)
    os.mkfifo("takes/e.bvh")
    os.symlink("f.bvh", "takes/f.bvh")
    os.symlink("nowhere", "takes/g.bvh")
    Path("takes/h.bvh").mkdir()  # not a file, and nothing is below
    shutil.copy(DATA / "arm.amc", "takes/i.amc")
    shutil.copy(DATA / "arm.amc", "takes/j.amc")
    os.mkfifo("takes/i.asf")
    os.symlink("j.asf", "takes/j.asf")
    assert run("distances", "takes", *POSITION, "--out", "D.npy", "--skip-errors") == 3
    _, *errors = lines(capsys.readouterr().err)[-8:]
    assert [re.sub(r".*\b([b-j]\.(bvh|amc)).*", r"\1", error) for error in errors] == [
        "b.bvh", "c.bvh", "e.bvh", "f.bvh", "g.bvh", "i.amc", "j.amc",
    ]  # fmt: skip
    assert "e.bvh is a named pipe that no program writes to" in errors[2]
    assert "i.asf is a named pipe that no program writes to" in errors[5]
    assert "symbolic links" in errors[3]
    assert "symbolic links" in errors[6]


# Warnings of one kind


def test_warnings_that_differ_in_numbers_are_one():
    notes = [Note(f"x/{name}.bvh", f"{name}.bvh: it is {n} m, pass scale=0.01") for n, name in enumerate("abc")]
    (line, category), (other, _), (single, _) = group(
        [*notes, Note("d", "it is 3 m, pass scale=0.1"), Note("e", "no unit")], ["x/a.bvh", "x/b.bvh", "x/c.bvh", *"de"]
    )
    assert line == "in 3 of 5 files (a.bvh, b.bvh, c.bvh), of the first: it is 0 m, pass scale=0.01"
    assert category is UserWarning
    assert other == "d: it is 3 m, pass scale=0.1"  # another remedy is another kind
    assert single == "e: no unit"
    assert group(notes[:1], ["x/a.bvh"]) == [("a.bvh: it is 0 m, pass scale=0.01", UserWarning)]
    assert group([Note("a", "one"), Note("a", "two")], ["a", "b"]) == [("a: one", UserWarning), ("a: two", UserWarning)]


def test_files_in_words():
    names = list("abcdefgh")
    assert count_files(names, names) == "all 8 files"
    assert count_files(names[:7], names) == "7 of 8 files (a, b, c, d, e and 2 more)"
    assert count_files(["x/a", "y/b"], ["x/a", "y/b", "z/a"]) == "2 of 3 files (x/a, y/b)"  # which a is not clear
    assert count_files(["x/a"], ["x/a", "y/b"]) == "x/a"


def test_warnings_of_one_kind_are_one_line(gait, capsys):
    for path in gait:
        save_bvh(f"{path.stem}.bvh", load_bvh(path), scale=0.01)
    assert run("distances", "a.bvh", "d.bvh", *gait, *POSITION, "--out", "D.npy") == 0
    (line,) = [line for line in lines(capsys.readouterr().err) if "warning" in line]
    assert re.match(r"warning: in 2 of 4 files \(.*\)(, of the first)?: the skeleton is 1\d\d m from end to end", line)
    assert "if the file is in centimetres, pass --scale 0.01" in line


def test_a_direction_that_points_down_is_an_option_that_works(gait, capsys):
    motion = load_bvh(gait[0])
    down = Motion(
        motion.skeleton, motion.angles, motion.frame_rate, root_angles=motion.root_angles + np.array([np.pi, 0, 0])
    )
    save_bvh("down.bvh", down, scale=1.0)
    assert run("info", "down.bvh") == 0
    (option,) = re.findall(r"pass (--up=-?\w)", capsys.readouterr().err)
    assert run("info", "down.bvh", option) == 0
    assert "warning" not in capsys.readouterr().err


# Scales by the size


UNITS = {"metres": 1.0, "centimetres": 0.01, "millimetres": 0.001, "inches": 0.0254, "units of CMU": 0.0254 / 0.45}


def test_each_file_has_the_unit_that_makes_it_a_person(gait, capsys):
    motion = load_bvh(gait[0])
    for unit, scale in UNITS.items():
        save_bvh(f"{unit[0]}{unit[1]}.bvh", motion, scale=scale)
    files = sorted(Path(".").glob("*.bvh"))
    assert run("distances", *files, *POSITION, "--out", "D.npy", "--scale", "auto") == 0
    D, n = np.load("D.npy"), len(motion)
    for i in range(1, len(files)):
        np.testing.assert_allclose(np.diag(D[:n, i * n : (i + 1) * n]), 0, atol=2e-5)
    said = [line for line in lines(capsys.readouterr().err) if line.startswith("--scale auto: ")]
    assert len(said) == len(UNITS)
    for unit, scale in UNITS.items():
        (line,) = [line for line in said if f"{unit[0]}{unit[1]}.bvh" in line]
        assert (f": {unit}, --scale {scale:.4g}: 1." in line) or (
            unit == "metres" and ": as without --scale: 1." in line
        )


def test_files_of_one_unit_are_said_together_and_without_a_warning(gait, capsys):
    for path in gait:
        save_bvh(path.name, load_bvh(path), scale=0.01)
    assert run("info", "a.bvh", "d.bvh", "--scale", "auto") == 0
    captured = capsys.readouterr()
    (line,) = lines(captured.err)
    assert re.fullmatch(r"--scale auto: all 2 files: centimetres, --scale 0\.01: 1\.\d+( to 1\.\d+)? m from .*", line)


def chain(length):
    """Write a skeleton of one bone, as long as this."""
    save_bvh("one.bvh", Motion(Skeleton([Bone("arm", None, (0, length, 0), "ZXY")], "parent"), np.zeros((2, 3)), 30))


def test_another_unit_that_is_possible_is_said(capsys):
    chain(100)  # a child of 1 m, or a tall person in inches
    assert run("info", "one.bvh", "--scale", "auto") == 0
    (line,) = lines(capsys.readouterr().err)
    assert "are possible too" in line
    assert {"inches", "centimetres"} == set(re.findall("inches|centimetres", line))


def test_a_size_that_is_that_of_no_person_is_refused(capsys):
    for length in (0.01, 2e6):
        Path("one.bvh").unlink(missing_ok=True)
        chain(length)
        assert run("info", "one.bvh", "--scale", "auto") == 1
        assert "the size of a person in none of metres, centimetres" in capsys.readouterr().err


def test_a_unit_that_a_file_states_is_kept(cmu, capsys):
    assert run("info", cmu[0]) == 0
    expected = capsys.readouterr().out
    assert run("info", cmu[0], "--scale", "auto") == 0
    captured = capsys.readouterr()
    assert captured.out == expected
    assert "as without --scale" in captured.err


def test_a_file_that_should_state_its_unit_and_does_not(cmu, capsys):
    asf = Path("cmu/subjects/01/01.asf")
    asf.write_text(re.sub(r"\n *length 0\.45", "", asf.read_text(), count=1))
    assert run("info", cmu[0]) == 1
    assert "no length under :units; pass --scale" in capsys.readouterr().err
    assert run("info", cmu[0], "--scale", "auto") == 0
    assert "--scale auto: " in capsys.readouterr().err
    asf.write_text("hello")  # an error is the same with a scale and without one
    assert run("info", cmu[0], "--scale", "auto") == 1
    assert "expected a keyword such as :version" in capsys.readouterr().err


def test_scales_of_compare(gait, capsys):
    with pytest.raises(SystemExit):
        main(["info", str(gait[0]), "--scale", "big"])
    assert "invalid positive number or auto value: 'big'" in capsys.readouterr().err
    Path("walks").mkdir()
    dataset = make_gait(n_subjects=2, n_sequences=1, duration=0.5, frame_rate=24, random_state=0)
    for motion, *labels in zip(dataset, dataset.subjects, dataset.actions, dataset.trials, strict=True):
        save_bvh(f"walks/{'_'.join(labels)}.bvh", motion, scale=0.01)
    assert run("compare", "walks", "--scale", "auto", "--jobs", "1") == 0
    captured = capsys.readouterr()
    assert "--scale auto: all 4 files: centimetres, --scale 0.01" in captured.err
    assert run("compare", "walks", "--scale", "0.01", "--jobs", "1") == 0
    times = re.compile(r"[\d.]+ s$|/.*", re.MULTILINE)
    assert times.sub("", capsys.readouterr().out) == times.sub("", captured.out)


@pytest.mark.slow
def test_a_compressed_file_that_holds_too_much_is_an_error_of_a_process(capsys):
    """Three megabytes that hold three gigabytes of blanks, in a process whose memory is bounded."""
    blanks = b" " * (1 << 24)
    with gzip.open("bomb.bvh.gz", "wb", 1) as file:
        file.write(b"HIERARCHY\n")
        for _ in range(190):
            file.write(blanks)
    limit = "import resource, sys; resource.setrlimit(resource.RLIMIT_DATA, (1 << 30, 1 << 30)); "
    program = limit + "from skpose._cli.main import main; sys.exit(main(['info', 'bomb.bvh.gz']))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "bomb.bvh.gz: its gzip compression holds more than 67 MB, over 100 times its size" in done.stderr


# Frame rates of files that state them


@pytest.mark.parametrize("option", [[], ["--amc-frame-rate", "60"]])
def test_the_rate_of_amc_files_is_no_other_files(option, cmu, gait, capsys):
    """Each of a folder of both is at its own rate."""
    assert run("info", gait[0], cmu[1], *option) == 0
    out, err = capsys.readouterr()
    assert "20 frames at 20 Hz, 1.00 s" in out
    assert ("3 frames at 60 Hz" if option else "3 frames at 30 Hz by index.csv") in out
    assert "Frame Time" not in err


def test_the_rate_of_all_files(cmu, gait, capsys):
    assert run("info", gait[0], cmu[1], "--file-frame-rate", "60", "--amc-frame-rate", "30") == 0
    out, err = capsys.readouterr()
    assert out.count("frames at 60 Hz") == 2
    assert "takes/a.bvh: --file-frame-rate 60 replaces the 20 Hz of Frame Time, so that it lasts 0.333 times" in err
    assert f"{cmu[1]}: --file-frame-rate 60 replaces the 30 Hz that index.csv states" in err


def test_remedies_for_rates_are_options_that_work(capsys):
    """Of TRC files, the message advised an option of AMC files."""
    import damaged

    text = damaged.trc_file().decode()
    Path("zero.trc").write_text(
        text.replace("100.00\t100.00", "0\t0").replace("\t0.0", "\t0.").replace("\t0.01", "\t0.1")
    )
    motion = make_gait(n_subjects=1, n_sequences=1, duration=1.0, frame_rate=20, random_state=0).motions[0]
    save_bvh("one.bvh", motion[:1])
    still = Path("one.bvh").read_text().replace("Frame Time: 0.05", "Frame Time: 0")
    Path("still.bvh").write_text(still)
    Path("slow.bvh").write_text(
        still.replace("Frame Time: 0", "Frame Time: 33.333").replace("Frames: 1", "Frames: 2") + still.splitlines()[-1]
    )
    for name, said in (
        ("still.bvh", "--file-frame-rate chooses"),
        ("slow.bvh", "the rate is 30.0003 Hz, --file-frame-rate 30;"),
    ):
        run("info", name)
        assert said in capsys.readouterr().err
        assert run("info", name, "--file-frame-rate", "30") == 0
        out, err = capsys.readouterr()
        assert "at 30 Hz" in out
        assert not err
    Path("contradiction.trc").write_text(text.replace("100.00\t100.00", "250\t250"))
    assert run("info", "contradiction.trc") == 1
    assert "--file-frame-rate chooses the rate" in capsys.readouterr().err
    assert run("info", "contradiction.trc", "--file-frame-rate", "100") == 0


def test_a_scale_by_size_does_not_hide_that_numbers_are_angles(capsys):
    import damaged

    Path("imu.trc").write_text(damaged.trc_file().decode().replace("\tmm\t", "\trad\t"))
    assert run("info", "imu.trc", "--scale", "auto") == 1
    assert "these are angles, no positions of markers" in capsys.readouterr().err


def test_blanks_and_texts_are_called_what_they_are(capsys):
    Path("bomb.bvh.gz").write_bytes(gzip.compress(b" " * (80 << 20)))
    Path("README.md").write_text("# Walks\n\n55 motion files\n")
    for name, said in (
        ("bomb.bvh.gz", "its gzip compression holds more than"),
        ("README.md", "this is not a motion file"),
    ):
        assert run("info", name) == 1
        assert said in capsys.readouterr().err
