"""The command line: the files that it writes, its output, and one line on stderr for each error."""

import os
import shutil
import sys
import warnings
from pathlib import Path

import damaged
import numpy as np
import pytest
from conftest import DATA
from scipy.sparse import load_npz

from skpose import Motion, PoseKNeighborsTransformer, PoseRadiusNeighborsTransformer, Skeleton, pose_distances
from skpose._cli import options, parser, parser_pages
from skpose._cli.main import main
from skpose._parallel.backends import from_workers
from skpose._parallel.checkpoint import IDENTITY, FileCheckpoint
from skpose.io import load_amc, load_asf, load_bvh
from skpose.metrics._registry import METRICS
from skpose.motions._matrix import ALIGNMENTS
from skpose.view._embeddings import EMBEDDINGS

BVH = str(DATA / "biped.bvh")
RATE = "--amc-frame-rate", "60"  # without which a warning says that 120 Hz is taken


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Two copies of a BVH file, in the current folder."""
    monkeypatch.chdir(tmp_path)
    for name in ("a.bvh", "b.bvh"):
        shutil.copy(BVH, tmp_path / name)
    return ["a.bvh", "b.bvh"]


@pytest.fixture
def sent(monkeypatch):
    """Numbers of tasks that are sent to workers; even small work is sent."""
    numbers = []

    def counted(function, shared, tasks, n_jobs):
        numbers.append(len(tasks))
        return from_workers(function, shared, tasks, n_jobs)

    monkeypatch.setattr("skpose.metrics._tiled.WORTH_SENDING", 0)
    monkeypatch.setattr("skpose.metrics._tiled.from_workers", counted)
    return numbers


@pytest.fixture
def skeleton_and_poses():
    motion = load_bvh(BVH, scale=0.01)
    return Skeleton.mean([motion.skeleton]), np.concatenate([motion.angles] * 2)


def error_line(arguments, capsys, status=1):
    """Run a command that fails; return its one line on stderr."""
    if status == 2:
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        assert stop.value.code == 2
        return capsys.readouterr().err.splitlines()[-1]
    assert main(arguments) == status
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("skpose: ")
    return line


@pytest.mark.parametrize(
    "options", [[], ["--metric", "position", "--dtype", "float32"], ["--backend", "loky", "--jobs", "2"]]
)
def test_distances(files, skeleton_and_poses, capsys, sent, options):
    skeleton, X = skeleton_and_poses
    assert main(["distances", *files, "--scale", "0.01", "--out", "D.npy", *options]) == 0
    out = capsys.readouterr().out
    D = np.load("D.npy", mmap_mode="r")
    dtype = np.float32 if "float32" in options else np.float64
    metric = "position" if "position" in options else "spatial"
    np.testing.assert_array_equal(D, pose_distances(X.astype(dtype), skeleton=skeleton, metric=metric))
    n = len(X) // 2
    assert out.splitlines()[:2] == [f"{0:>8} to {n - 1:<8} a.bvh", f"{n:>8} to {2 * n - 1:<8} b.bvh"]
    assert sorted(os.listdir()) == ["D.npy", "a.bvh", "b.bvh"]
    assert bool(sent) == ("loky" in options)


def test_distances_of_amc_files_at_another_rate(tmp_path):
    motion = load_amc(DATA / "arm.amc", DATA / "arm.asf", frame_rate=60)
    X = motion.resample(20).angles
    out, asf = str(tmp_path / "D.npy"), str(DATA / "arm.asf")
    files = [str(DATA / "arm.amc")]
    options = ["--amc-frame-rate", "60", "--frame-rate", "20", "--out", out]
    assert main(["distances", *files, *options]) == 0  # finds the skeleton next to the file
    np.testing.assert_array_equal(np.load(out), pose_distances(X, skeleton=Skeleton.mean([motion.skeleton])))
    Path(out).unlink()
    shutil.copy(files[0], tmp_path / "swing.amc")
    assert main(["distances", str(tmp_path / "swing.amc"), *options, "--asf", asf]) == 0
    np.testing.assert_array_equal(np.load(out), pose_distances(X, skeleton=Skeleton.mean([motion.skeleton])))


def test_with_ball_joints(files, skeleton_and_poses):
    skeleton, X = skeleton_and_poses
    X = Motion(skeleton, X, 1).to_rotvec().angles
    options = ["--scale", "0.01", "--rotations", "rotvec"]
    assert main(["distances", *files, *options, "--out", "D.npy"]) == 0
    D = pose_distances(X, skeleton=skeleton.to_rotvec(), metric="spatial")
    np.testing.assert_allclose(np.load("D.npy"), D, rtol=0, atol=1e-10)
    assert main(["distances", *files, *options[:2], "--out", "E.npy"]) == 0
    assert np.abs(np.load("E.npy") - D).max() > 1e-4
    assert main(["neighbors", *files, *options, "--neighbors", "1", "--out", "G.npz"]) == 0
    np.fill_diagonal(D, np.inf)
    np.testing.assert_allclose(load_npz("G.npz").data, D.min(axis=1), rtol=0, atol=1e-10)


def test_neighbors(files, skeleton_and_poses):
    skeleton, X = skeleton_and_poses
    assert main(["neighbors", *files, "--scale", "0.01", "--neighbors", "2", "--out", "G.npz"]) == 0
    expected = PoseKNeighborsTransformer(skeleton, n_neighbors=2).fit(X).kneighbors_graph(mode="distance")
    np.testing.assert_array_equal(load_npz("G.npz").toarray(), expected.toarray())
    assert main(["neighbors", *files, "--scale", "0.01", "--radius", "0.5", "--out", "R.npz"]) == 0
    assert main(["neighbors", *files, "--scale", "0.01", "--out", "F.npz"]) == 1  # five neighbours among four poses
    assert not Path("F.npz").exists()
    expected = PoseRadiusNeighborsTransformer(skeleton, radius=0.5).fit(X).radius_neighbors_graph(mode="distance")
    np.testing.assert_array_equal(load_npz("R.npz").toarray(), expected.toarray())


@pytest.mark.slow
def test_on_a_cluster(files, sent):
    from dask.distributed import Client, LocalCluster

    arguments = ["distances", *files, "--scale", "0.01"]
    assert main([*arguments, "--out", "D.npy"]) == 0
    with LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=":0") as cluster, Client(cluster):
        on_cluster = ["--backend", "dask", "--scheduler", cluster.scheduler_address]
        assert main([*arguments, *on_cluster, "--out", "E.npy"]) == 0
    assert Path("D.npy").read_bytes() == Path("E.npy").read_bytes()
    assert sent == [1]


@pytest.mark.parametrize("name", ["biped.bvh", "arm.amc", "arm.asf"])
def test_info(name, capsys):
    assert main(["info", str(DATA / name), *RATE]) == 0
    out = capsys.readouterr().out
    skeleton = load_bvh(BVH).skeleton if name == "biped.bvh" else load_asf(DATA / "arm.asf")
    assert f"{skeleton.n_joints} joints besides the root, {skeleton.n_dofs} degrees of freedom" in out
    assert (" Hz" in out) == (name != "arm.asf")
    assert all(joint in out for joint in skeleton.joint_names)


def test_info_of_several_files(capsys):
    files = [str(DATA / name) for name in ("biped.bvh", "arm.amc", "arm.asf")]
    each = []
    for file in files:
        assert main(["info", file, *RATE]) == 0
        each.append(f"{file}\n{capsys.readouterr().out}")
    assert main(["info", *files, *RATE]) == 0
    assert capsys.readouterr().out == "\n".join(each)


ODD = {
    "nan.bvh": (("45.5", "nan"), "on_nan", ["--on-nan", "drop"]),
    "short.bvh": (("Frames: 2", "Frames: 3"), "trust", ["--trust", "rows"]),
    "stretched.bvh": (("CHANNELS 1 Xrotation", "CHANNELS 1 Xposition"), "stretch", ["--stretch", "mean"]),
    "rest.amc": (("tip 12\n", ""), "missing", ["--missing", "rest"]),
}


@pytest.mark.filterwarnings("ignore:nan.bvh. 1 of 2 frames:UserWarning")
@pytest.mark.parametrize("name", ODD)
def test_the_options_of_messages_are_options_of_the_command_line(name, tmp_path, monkeypatch, capsys):
    """The message of an error is one that a user of the command line can follow as it stands."""
    monkeypatch.chdir(tmp_path)
    (old, new), option, remedy = ODD[name]
    text = Path(BVH if name.endswith("bvh") else DATA / "arm.amc").read_text(encoding="utf-8")
    assert old in text
    Path(name).write_text(text.replace(old, new), encoding="utf-8")
    more = [] if name.endswith("bvh") else ["--asf", str(DATA / "arm.asf"), *RATE]
    for command in (["info"], ["distances", "--out", "D.npy"], ["neighbors", "--neighbors", "1", "--out", "G.npz"]):
        line = error_line([*command, name, *more], capsys)
        assert " ".join(remedy) in line
        assert f"{option}=" not in line
        if command[0] != "neighbors":  # which need more poses than some of the files have
            assert main([*command, name, *more, *remedy]) == 0
            capsys.readouterr()


@pytest.mark.filterwarnings("ignore:biped.bvh. root='Chest' leaves out:UserWarning")
def test_the_root_is_an_option_of_the_command_line(capsys):
    assert main(["info", BVH, "--root", "Chest"]) == 0
    out = capsys.readouterr().out
    assert f"{load_bvh(BVH, root='Chest').skeleton.n_joints} joints besides the root" in out
    assert "Left Leg" not in out
    line = error_line(["info", BVH, "--root", "chest"], capsys)
    assert "--root chest is no joint of this file; expected one of 'Arm', 'Chest'" in line


def test_an_amc_file_with_the_name_of_hdm05_finds_its_skeleton(tmp_path, capsys):
    shutil.copy(DATA / "arm.asf", tmp_path / "HDM_bd.asf")
    shutil.copy(DATA / "arm.amc", tmp_path / "HDM_bd_squat1Reps_001_120.amc")
    assert main(["info", str(tmp_path / "HDM_bd_squat1Reps_001_120.amc")]) == 0
    assert "upperarm" in capsys.readouterr().out


COMMANDS = ["compare", "reproduce", "distances", "neighbors", "motions", "find", "mean", "between", "retarget"]
COMMANDS += ["convert", "view", "explore", "info"]


@pytest.mark.parametrize("command", [[], *([name] for name in COMMANDS)])
def test_help(command, capsys):
    with pytest.raises(SystemExit) as stop:
        main([*command, "--help"])
    assert stop.value.code == 0
    assert "Exit status: 0 success" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["info", "none.bvh"], "none.bvh"),
        (
            ["info", "a.txt"],
            "a.txt: this is not a motion file: expected HIERARCHY (BVH), a keyword such as :DEGREES or",
        ),
        (["distances", "alone_1.amc", "--out", "D.npy"], "needs its skeleton and there is no alone.asf"),
        (["neighbors", "a.bvh", "--neighbors", "9999", "--out", "G.npz"], "Expected n_neighbors < n_samples_fit"),
        (["distances", "cut.bvh", "--out", "D.npy"], "cut.bvh, line"),
    ],
)
def test_errors_are_one_line(files, capsys, arguments, message):
    Path("alone_1.amc").write_text(":DEGREES\n1\n")
    Path("a.txt").write_text("hello")
    Path("cut.bvh").write_text("HIERARCHY\nROOT hips\n{\n")
    assert message in error_line(arguments, capsys)
    assert not Path("D.npy").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ["distances", "--out", "D.npy"],
        ["distances", "a.bvh", "--out", "D.npy", "--frame-rate", "-1"],
        ["distances", "a.bvh", "--out", "D.npy", "--jobs", "0"],
        ["compare", "--jobs", "0"],
        ["distances", "a.bvh", "--out", "D.txt"],
        ["distances", "a.bvh", "--out", "D"],
        ["neighbors", "a.bvh", "--out", "G.npy"],
        ["distances", "a.bvh", "--out", "D.npy", "--metric", "cosine"],
        ["distances", "a.bvh", "--out", "D.npy", "--scheduler", "tcp://127.0.0.1:1"],
        ["neighbors", "a.bvh", "--out", "G.npz", "--neighbors", "2", "--radius", "1"],
        ["neighbors", "a.bvh", "--out", "G.npz", "--neighbors", "2.5"],
    ],
)
def test_wrong_options_have_exit_status_2(files, capsys, arguments):
    assert "error: " in error_line(arguments, capsys, status=2)
    assert sorted(os.listdir()) == files


def test_a_disk_that_is_too_small_is_an_error_before_the_computation(files, capsys, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: shutil._ntuple_diskusage(10**9, 10**9, 100))
    assert "the disk has 0.0 GB free" in error_line(["distances", *files, "--out", "D.npy"], capsys)
    assert not Path("D.npy").exists()


def test_an_error_names_the_package_to_install(files, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "dask.distributed", None)
    monkeypatch.setitem(sys.modules, "ray", None)
    for backend in ("dask", "ray"):
        line = error_line(["distances", *files, "--out", "D.npy", "--backend", backend], capsys)
        assert line == f"skpose: --backend {backend} needs {backend}: pip install 'skpose[{backend}]'"


def test_units_and_hands_are_named_as_options(tmp_path, monkeypatch, capsys):
    """Remedies of the library are options here: scale=0.01 is --scale 0.01, and hands=False is --no-hands."""
    monkeypatch.chdir(tmp_path)
    for name, width in (("a.npz", 72), ("b.npz", 156)):  # SMPL and SMPL-H
        np.savez(name, poses=np.zeros((2, width)), trans=np.zeros((2, 3)), mocap_framerate=60.0)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert main(["info", BVH]) == 0
        assert "with --scale 1 metres a unit" in (message := capsys.readouterr().err)
        assert "if the file is in centimetres, pass --scale 0.01, which makes" in message
        assert main(["distances", "a.npz", "b.npz", "--out", "D.npy"]) == 1
        assert "without their hands, --no-hands, motions of SMPL and SMPL-H" in capsys.readouterr().err


def test_warnings_are_one_line_and_hands_can_be_left_out(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, width in (("a.npz", 72), ("b.npz", 156)):  # SMPL and SMPL-H
        np.savez(name, poses=np.zeros((2, width)), trans=np.zeros((2, 3)), mocap_framerate=60.0)
    command = ["distances", "a.npz", "b.npz", "--metric", "position", "--up", "y", "--out", "D.npy"]
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert main(command) == 1
        warning, error = capsys.readouterr().err.splitlines()
        assert warning.startswith("skpose: warning: in all 2 files: bones have the lengths of a person")
        assert "--model takes them from" in warning
        assert error.startswith("skpose: b.npz has no bone-wise mean with a.npz")
        assert main([*command, "--no-hands"]) == 0
    np.testing.assert_array_equal(np.load("D.npy"), np.zeros((4, 4)))


def test_the_notes_of_a_matrix_that_was_deleted_unfinished_are_too(tmp_path):
    out = tmp_path / "D.npy"
    FileCheckpoint(out).start({IDENTITY: "of other poses"}, [])
    assert main(["distances", BVH, "--metric", "position", "--out", str(out)]) == 0
    assert list(tmp_path.iterdir()) == [out]


def test_help_names_the_metrics_of_the_registry():
    """The parser has a copy, so that --help imports neither numba nor scikit-learn."""
    assert tuple(METRICS) == options.METRICS
    assert ALIGNMENTS == parser.ALIGNMENTS
    assert EMBEDDINGS == parser_pages.EMBEDDINGS


@pytest.mark.parametrize("kind", ["TRC", "C3D"])
def test_info_of_markers(kind, tmp_path, capsys):
    (tmp_path / f"walk.{kind.lower()}").write_bytes(damaged.FILES[kind][0])
    assert main(["info", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "20 frames at 100 Hz, 0.20 s"
    assert lines[1] == f"3 points, {'y' if kind == 'TRC' else 'z'} is up"
    assert [line.split() for line in lines[4:]] == [["hip", "0.0%"], ["knee", "15.0%"], ["ankle", "0.0%"]]
    assert main(["info", str(tmp_path), "--up=-x", "--scale", "0.002", "--trust", "rows"]) == 0
    assert capsys.readouterr().out.splitlines()[1] == "3 points, x is up"
    line = error_line(["distances", str(tmp_path / f"walk.{kind.lower()}"), "--out", str(tmp_path / "D.npy")], capsys)
    assert f"this is a {kind} file, positions of markers without a skeleton: load_{kind.lower()} reads it" in line
