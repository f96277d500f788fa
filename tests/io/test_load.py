"""Formats recognised by content, and the sources that files may come from."""

import bz2
import gzip
import io
import shutil
import warnings
import zipfile
from pathlib import Path

import damaged
import numpy as np
import pytest
from conftest import DATA

from skpose.io import (
    MocapFormatError,
    _source,
    asf_path,
    file_format,
    load_amc,
    load_asf,
    load_bvh,
    load_keypoints,
    load_motion,
)

BVH, AMC, ASF = DATA / "biped.bvh", DATA / "arm.amc", DATA / "arm.asf"


def same(one, other):
    assert one.skeleton == other.skeleton
    for name in ("angles", "root_positions", "root_angles", "frame_rate"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_the_content_decides_on_the_format_not_the_name(tmp_path):
    shutil.copy(BVH, tmp_path / "a.amc")
    shutil.copy(AMC, tmp_path / "b.txt")
    same(load_motion(tmp_path / "a.amc", scale=0.01), load_bvh(BVH, scale=0.01))
    same(load_motion(tmp_path / "b.txt", asf=ASF, frame_rate=60), load_amc(AMC, ASF, frame_rate=60))
    assert file_format(tmp_path / "a.amc") == "BVH"
    assert file_format(str(tmp_path / "b.txt")) == "AMC"
    assert file_format(ASF) == "ASF"


def test_an_amc_file_finds_its_skeleton(tmp_path):
    same(load_motion(AMC, frame_rate=60), load_amc(AMC, ASF, frame_rate=60))
    shutil.copy(AMC, tmp_path / "07_12.amc")
    with pytest.raises(FileNotFoundError, match=r"07_12\.amc needs its skeleton and there is no .*07\.asf: pass asf="):
        load_motion(tmp_path / "07_12.amc")
    shutil.copy(ASF, tmp_path / "07.asf")
    same(load_motion(tmp_path / "07_12.amc", frame_rate=60), load_motion(AMC, frame_rate=60))
    (tmp_path / "07_13.amc.gz").write_bytes(gzip.compress(AMC.read_bytes()))
    same(load_motion(tmp_path / "07_13.amc.gz", frame_rate=60), load_motion(AMC, frame_rate=60))
    (tmp_path / "07_12.asf").write_text("a skeleton of its own comes first")
    with pytest.raises(MocapFormatError, match=r"07_12\.asf, line 1"):
        load_motion(tmp_path / "07_12.amc")


def test_options_are_passed_to_the_reader(tmp_path):
    (tmp_path / "a.bvh").write_text(BVH.read_text().replace("Frames: 2", "Frames: 3"))
    assert len(load_motion(tmp_path / "a.bvh", trust="rows")) == 2
    (tmp_path / "a.amc").write_text(AMC.read_text().replace("tip 12\n", ""))
    assert len(load_motion(tmp_path / "a.amc", asf=ASF, missing="rest", frame_rate=60)) == 3
    (tmp_path / "b.amc").write_text(AMC.read_text().replace("tip 12\n", "tip nan\n"))
    with pytest.warns(
        UserWarning, match=r"b\.amc: 1 of 3 frames have a number that is NaN or infinite and are left out"
    ):
        dropped = load_motion(tmp_path / "b.amc", asf=ASF, on_nan="drop", frame_rate=10)
    np.testing.assert_array_equal(dropped.times, [0.1, 0.2])  # the first frame is left out
    np.testing.assert_array_equal(dropped.angles, load_amc(AMC, ASF, frame_rate=60).angles[1:])
    with pytest.warns(UserWarning, match="root='Chest' leaves out 'Left Leg'"):
        same(load_motion(BVH, root="Chest"), load_bvh(BVH, root="Chest"))
    with pytest.raises(
        ValueError, match=r"root='hips' is for BVH files; .*arm\.amc is an AMC file, whose root its ASF"
    ):
        load_motion(AMC, root="hips")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a.txt: the file is empty, not a BVH, AMC or AMASS file"),
        ("hello\n", r"a.txt: this is not a motion file: expected HIERARCHY \(BVH\), a keyword .*, found 'hello'"),
        ("# 55 files\n\n55 motion files of walks\n", "this is not a motion file: .*, found '55 motion files of walks'"),
        ("3\nThree words here\nand\n", "this is not a motion file: .*, found '3'"),
        (":note: some\ntext\n", "this is not a motion file: .*, found ':note: some'"),
        (" \n" * 200_000, r"this is not a motion file: .*, found [\d,]+ blanks at its beginning"),
        ("1\nroot 0 0,5 0 0 0 0\nupperarm 1 2 3\n", "frame 1 ends without .*lowerarm"),
        (ASF.read_text(), r"a.txt: this is a skeleton \(ASF\), which has no motion: load_asf reads it"),
        ("# nothing else\n", "the file ends without a frame"),
        ("1\nroot 0 0 0 0 0 0\n", "frame 1 ends without .*upperarm"),
    ],
)
def test_files_that_are_neither(text, message, tmp_path):
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(MocapFormatError, match=message):
        load_motion(tmp_path / "a.txt", asf=ASF)


def test_blanks_that_gzip_has_made_small_are_called_that(tmp_path):
    """The message on a skeleton that is missing was no help."""
    path = tmp_path / "bomb.bvh.gz"
    path.write_bytes(gzip.compress(b" " * (80 << 20)))
    for load in (load_motion, load_bvh, file_format):
        with pytest.raises(MocapFormatError, match="its gzip compression holds more than"):
            load(path)


def test_files_of_no_format(tmp_path):
    (tmp_path / "a.txt").write_text("hello\n")
    (tmp_path / "b.txt").touch()
    with pytest.raises(
        MocapFormatError, match=r"a\.txt: this is not a motion file: expected HIERARCHY .*, found 'hello'"
    ):
        file_format(tmp_path / "a.txt")
    with pytest.raises(
        MocapFormatError, match=r"b\.txt: the file is empty, not a BVH, AMC, ASF, AMASS, TRC or C3D file"
    ):
        file_format(tmp_path / "b.txt")
    with pytest.raises(FileNotFoundError):
        file_format(tmp_path / "c.txt")


def test_the_asf_path_of_an_amc_file(tmp_path):
    assert asf_path(tmp_path / "07_12.amc") == tmp_path / "07.asf"
    assert asf_path(str(tmp_path / "my.first_walk.amc.gz")) == tmp_path / "my.first.asf"
    (tmp_path / "my.first_walk.asf").touch()
    assert asf_path(tmp_path / "my.first_walk.amc") == tmp_path / "my.first_walk.asf"


def test_the_asf_path_is_the_longest_part_of_the_name_that_exists(tmp_path):
    """HDM05 has one skeleton for each actor: HDM_bd.asf for HDM_bd_squat1Reps_001_120.amc."""
    amc = tmp_path / "HDM_bd_squat1Reps_001_120.amc.gz"
    assert asf_path(amc) == tmp_path / "HDM_bd_squat1Reps_001.asf"  # which does not exist
    for name in ("HDM.asf", "HDM_bd.asf", "HDM_bd_squat1Reps_001.asf", "HDM_bd_squat1Reps_001_120.asf"):
        (tmp_path / name).touch()
        assert asf_path(amc) == tmp_path / name
    assert asf_path(tmp_path / "walk.amc") == tmp_path / "walk.asf"  # nothing to strip


class OnlyRead:
    """A file object with no other method than read, such as a socket or an object in the cloud."""

    def __init__(self, data, most):
        self.data, self.most = io.BytesIO(data), most

    def read(self, size):
        return self.data.read(min(size, self.most))


def test_sources_of_a_file(tmp_path):
    path = tmp_path / "a.bvh.gz"
    path.write_bytes(gzip.compress(BVH.read_bytes()))
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.write(BVH, "a.bvh")
    with (
        BVH.open() as text,
        BVH.open("rb") as data,
        path.open("rb") as compressed,
        gzip.open(path) as opened,
        zipfile.ZipFile(tmp_path / "a.zip").open("a.bvh") as member,
    ):
        for file in (
            BVH, str(BVH), path, str(path), text, data, compressed, opened, member, io.StringIO(BVH.read_text()),
            io.BytesIO(BVH.read_bytes()), OnlyRead(BVH.read_bytes(), 7), OnlyRead(path.read_bytes(), 7),
        ):  # fmt: skip
            same(load_bvh(file), load_bvh(BVH))
            if hasattr(file, "closed"):
                assert not file.closed  # the caller closes it
    same(
        load_motion(io.StringIO(AMC.read_text()), asf=io.StringIO(ASF.read_text()), frame_rate=60),
        load_motion(AMC, frame_rate=60),
    )
    assert load_asf(io.BytesIO(gzip.compress(ASF.read_bytes()))) == load_asf(ASF)


def test_an_open_file_is_read_from_its_position():
    file = io.BytesIO(b"something else\n" + BVH.read_bytes())
    file.readline()
    same(load_bvh(file), load_bvh(BVH))


def test_errors_of_open_files():
    with pytest.raises(ValueError, match="an AMC file needs its skeleton: pass asf="):
        load_motion(io.StringIO(AMC.read_text()))
    with pytest.raises(MocapFormatError, match="the open file, line 1, column 1: expected HIERARCHY") as caught:
        load_bvh(io.StringIO("hello"))
    assert caught.value.filename == "the open file"
    with BVH.open() as file, pytest.raises(MocapFormatError, match=r"biped\.bvh, line 1"):
        load_asf(file)
    with pytest.raises(TypeError, match="expected a path or an open file to read, got int"):
        load_bvh(3)


@pytest.mark.parametrize("kept", [20, 100, 200, 300])
def test_damaged_compression(kept, tmp_path):
    whole = gzip.compress(BVH.read_bytes())
    (tmp_path / "cut.gz").write_bytes(whole[:kept])
    damaged = bytearray(whole)
    damaged[kept] ^= 0xFF
    (tmp_path / "damaged.gz").write_bytes(damaged)
    with pytest.raises(MocapFormatError, match=r"cut\.gz: its gzip compression is damaged or cut short"):
        load_bvh(tmp_path / "cut.gz")
    with pytest.raises(MocapFormatError, match=r"damaged\.gz"):
        load_bvh(tmp_path / "damaged.gz")
    (tmp_path / "other.bz2").write_bytes(bz2.compress(BVH.read_bytes()))
    with pytest.raises(MocapFormatError, match=r"other\.bz2"):
        load_bvh(tmp_path / "other.bz2")


def test_files_are_closed(tmp_path):
    """Also after an error; a file left open would be a ResourceWarning."""
    (tmp_path / "bad.bvh").write_text("HIERARCHY x")
    (tmp_path / "empty.bvh").touch()
    (tmp_path / "bad.gz").write_bytes(gzip.compress(b"HIERARCHY x"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_motion(BVH, scale=0.01)
        for name in ("bad.bvh", "empty.bvh", "bad.gz"):
            with pytest.raises(MocapFormatError):
                load_motion(tmp_path / name)


@pytest.mark.parametrize("size", [1, 20, 150, 400])
def test_chunks_may_end_anywhere(size, monkeypatch, tmp_path):
    """In the middle of the hierarchy, right before the frames, between two frames."""
    text = BVH.read_text()
    expected, motion = load_bvh(BVH), load_motion(AMC, frame_rate=60)
    monkeypatch.setattr(_source, "CHUNK", size)
    same(load_bvh(BVH), expected)
    same(load_motion(AMC, frame_rate=60), motion)
    (tmp_path / "bad.bvh").write_text(text.replace("45.5", "x"))
    with pytest.raises(MocapFormatError, match="line 47, column 38: a frame: expected a number, found 'x'"):
        load_bvh(tmp_path / "bad.bvh")


def test_a_directory_and_a_missing_file(tmp_path):
    for path in (tmp_path, tmp_path / "none.bvh"):
        with pytest.raises(OSError, match=Path(path).name):
            load_motion(path)


MOT = "Coordinates\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\n\nendheader\ntime\thip\tknee\n0\t1\t2\n0.1\t1\t2\n"


@pytest.mark.parametrize(
    "text",
    [MOT, MOT.replace("\n", "\r\n"), "name walk.mot\ndatacolumns 3\ndatarows 2\nendheader\n", "\n" * 999 + MOT],
)
def test_tables_of_opensim_are_refused_with_the_remedy(text, tmp_path):
    (tmp_path / "walk.mot").write_bytes(text.encode())
    for read in (load_motion, file_format):
        with pytest.raises(
            MocapFormatError,
            match=r"walk\.mot: this is a table of OpenSim .* only in a model \(\.osim\).* load_trc reads the markers",
        ):
            read(tmp_path / "walk.mot")


@pytest.mark.parametrize("kind", ["TRC", "C3D"])
def test_files_of_markers_are_recognised_and_name_their_reader(kind, tmp_path):
    for data in damaged.FILES[kind]:
        (tmp_path / "walk.bvh").write_bytes(data)
        assert file_format(tmp_path / "walk.bvh") == kind
        with pytest.raises(
            MocapFormatError, match=rf"walk\.bvh: this is a {kind} file, .* load_{kind.lower()} reads it"
        ):
            load_motion(tmp_path / "walk.bvh")
    message = {"C3D": "this is a C3D file, which load_c3d reads, not a BVH file", "TRC": "expected HIERARCHY"}[kind]
    with pytest.raises(MocapFormatError, match=message):
        load_bvh(tmp_path / "walk.bvh")


def test_an_array_names_its_reader(tmp_path):
    np.save(tmp_path / "a.npy", np.zeros((2, 3, 3)))
    with pytest.raises(MocapFormatError, match=r"this is an array \(\.npy\), not a motion: load_keypoints reads"):
        load_motion(tmp_path / "a.npy")


KINECT = "".join(f"{100 + i} {80 - i} {2000 + 7 * i} {i % 2}\n" for i in range(40))
ROUTES = [
    ('{"people": []}', r"this is JSON: load_keypoints reads keypoints of OpenPose, MediaPipe and COCO"),
    ("\n [[1, 2, 3]]", "this is JSON: load_keypoints reads"),
    (KINECT, r"this is a table of numbers without names, such as Kinect's text of joints: numpy\.loadtxt reads it"),
    ("20 40\n" + KINECT, "this is a table of numbers without names"),  # with the counts of frames and joints first
    (KINECT.replace(" ", ",").replace("\n", ".5\n"), "this is a table of numbers without names"),
    ("0.139 0.432 2.86 1\n" * 9000, "this is a table of numbers without names"),
    ("frame,nose_x,nose_y,nose_z\n0,1,2,3\n", r"this is a table with a header \(CSV\): load_keypoints reads"),
    ("time;x;y;z\n0;1;2;3\n", r"this is a table with a header \(CSV\)"),
]


@pytest.mark.parametrize(("text", "message"), ROUTES)
def test_files_that_are_no_motions_name_the_route_that_reads_them(text, message, tmp_path):
    (tmp_path / "walk.bvh").write_text(text)
    for read in (load_motion, file_format):
        with pytest.raises(MocapFormatError, match=rf"walk\.bvh: {message}.*fit_skeleton and inverse_kinematics find"):
            read(tmp_path / "walk.bvh")


def test_frames_of_an_amc_file_are_no_table_of_numbers(tmp_path):
    text = AMC.read_text()
    (tmp_path / "a.amc").write_text(text[text.index("1\n") :])
    assert file_format(tmp_path / "a.amc") == "AMC"


@pytest.mark.parametrize("key", ["positions", "keypoints"])
def test_an_archive_of_positions_names_its_reader(key, tmp_path):
    np.savez(tmp_path / "a.npz", **{key: np.zeros((2, 3, 3)), "fps": 30})
    with pytest.raises(MocapFormatError, match=rf"it has {key}, positions of points.*load_keypoints"):
        load_motion(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (BVH.read_bytes(), "found 'HIERARCHY': load_bvh reads it"),
        (ASF.read_bytes(), "found ':version': load_motion reads it"),
        (damaged.FILES["TRC"][0], "found 'PathFileType': load_trc reads it"),
        (damaged.FILES["C3D"][0], "found C3D: load_c3d reads it"),
        (KINECT.encode(), "found a table of numbers without names, .* numpy.loadtxt reads it"),
    ],
)
def test_load_keypoints_names_the_reader_of_other_files(data, message, tmp_path):
    (tmp_path / "a.json").write_bytes(data)
    with pytest.raises(MocapFormatError, match=f"expected keypoints as JSON, CSV with a header, .*{message}"):
        load_keypoints(tmp_path / "a.json")
