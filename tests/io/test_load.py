"""Formats recognised by content, and the sources that files may come from."""

import gzip
import inspect
import io
import shutil

import damaged
import numpy as np
import pytest
from conftest import DATA

from skpose.io import MocapFormatError, _source, load_amc, load_bvh, load_keypoints, load_motion
from skpose.io._acclaim import asf_path
from skpose.io._formats import FORMATS, format_of

BVH, AMC, ASF = DATA / "biped.bvh", DATA / "arm.amc", DATA / "arm.asf"
MOT = "Coordinates\nnRows=2\nnColumns=2\ninDegrees=yes\nendheader\ntime\tknee\n0\t1\n1\t2\n"


def same(one, other):
    assert one.skeleton == other.skeleton
    for name in ("angles", "root_positions", "root_angles", "frame_rate"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_the_content_decides_on_the_format_not_the_name(tmp_path):
    shutil.copy(BVH, tmp_path / "a.amc")
    shutil.copy(AMC, tmp_path / "b.txt")
    same(load_motion(tmp_path / "a.amc", scale=0.01), load_bvh(BVH, scale=0.01))
    same(load_motion(tmp_path / "b.txt", asf=ASF, frame_rate=60), load_amc(AMC, ASF, frame_rate=60))


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        (kind, {"NPY": "arrays", "NPZ": "arrays", "motion": "NPZ", "AMASS": "SMPL"}.get(kind, kind))
        for kind in damaged.FILES
    ],
)
def test_every_format_is_recognised_and_has_the_options_of_its_loader(kind, name):
    for data in damaged.FILES[kind]:
        found = format_of(io.BytesIO(data))
        assert (found.name, found in FORMATS) == (name, True)
        assert set(found.options) == set(inspect.signature(found.load).parameters) - {"path", "source"}


@pytest.mark.parametrize(
    "text",
    [MOT, "1 2 3\n4 5 6\n", "hello", "frame,time,frame_rate,up,root_axes,a_x,a_y,a_z\n0,0,1,y,x,0,0,0\n"],
)
def test_files_of_no_format(text):
    with pytest.raises(MocapFormatError):
        load_motion(io.StringIO(text))
    with pytest.raises(MocapFormatError):
        load_keypoints(io.StringIO(text), names=["a"], frame_rate=30)


def test_an_amc_file_finds_its_skeleton(tmp_path):
    same(load_motion(AMC, frame_rate=60), load_amc(AMC, ASF, frame_rate=60))
    (tmp_path / "07_13.amc.gz").write_bytes(gzip.compress(AMC.read_bytes()))
    with pytest.raises(FileNotFoundError, match="asf="):
        load_motion(tmp_path / "07_13.amc.gz")
    shutil.copy(ASF, tmp_path / "07.asf")
    same(load_motion(tmp_path / "07_13.amc.gz", frame_rate=60), load_motion(AMC, frame_rate=60))


def test_options_are_passed_to_the_reader(tmp_path):
    (tmp_path / "a.bvh").write_text(BVH.read_text().replace("Frames: 2", "Frames: 3"))
    assert len(load_motion(tmp_path / "a.bvh", trust="rows", missing="rest")) == 2
    (tmp_path / "a.amc").write_text(AMC.read_text().replace("tip 12\n", ""))
    assert len(load_motion(tmp_path / "a.amc", asf=ASF, missing="rest", frame_rate=60)) == 3
    with pytest.warns(UserWarning, match="root='Chest' leaves out"):
        same(load_motion(BVH, root="Chest"), load_bvh(BVH, root="Chest"))
    with pytest.raises(ValueError, match="root"):
        load_motion(AMC, root="hips")
    with pytest.raises(TypeError, match="fps"):
        load_motion(BVH, fps=30)
    with pytest.raises(MocapFormatError, match="load_trc"):
        load_motion(io.BytesIO(damaged.trc_file()))


def test_the_asf_path_is_the_longest_part_of_the_name_that_exists(tmp_path):
    """HDM05 has one skeleton for each actor: HDM_bd.asf for HDM_bd_squat1Reps_001_120.amc."""
    amc = tmp_path / "HDM_bd_squat1Reps_001_120.amc.gz"
    assert asf_path(amc) == tmp_path / "HDM_bd_squat1Reps_001.asf"  # which does not exist
    for name in ("HDM.asf", "HDM_bd.asf", "HDM_bd_squat1Reps_001.asf", "HDM_bd_squat1Reps_001_120.asf"):
        (tmp_path / name).touch()
        assert asf_path(amc) == tmp_path / name
    assert asf_path(tmp_path / "walk.amc") == tmp_path / "walk.asf"  # nothing to strip


def test_sources_of_a_file(tmp_path):
    path = tmp_path / "a.bvh.gz"
    path.write_bytes(gzip.compress(BVH.read_bytes()))
    with BVH.open() as text, path.open("rb") as compressed:
        for file in (str(BVH), path, text, compressed, io.StringIO(BVH.read_text()), io.BytesIO(BVH.read_bytes())):
            same(load_bvh(file), load_bvh(BVH))
        assert not text.closed  # the caller closes it


def test_what_gzip_holds_is_limited(monkeypatch):
    monkeypatch.setattr(_source, "LARGEST", 100_000)
    with pytest.raises(MocapFormatError, match="gzip"):
        load_bvh(io.BytesIO(gzip.compress(b" " * 200_000)))


def test_a_link_to_an_amc_file_finds_the_skeleton_of_the_file(tmp_path):
    (tmp_path / "link.amc").symlink_to(AMC)
    same(load_motion(tmp_path / "link.amc", frame_rate=60), load_motion(AMC, frame_rate=60))


@pytest.mark.parametrize("kept", [20, 300])
def test_damaged_compression(kept):
    damaged = bytearray(gzip.compress(BVH.read_bytes()))
    damaged[kept] ^= 0xFF
    for data in (damaged, damaged[:kept]):
        with pytest.raises(MocapFormatError):
            load_bvh(io.BytesIO(data))


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(IsADirectoryError, match="each of its files"):
        load_motion(tmp_path)
