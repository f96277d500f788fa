"""Formats recognised by content, and the sources that files may come from."""

import bz2
import gzip
import io
import shutil
import zipfile

import numpy as np
import pytest
from conftest import DATA

from skpose.io import (
    MocapFormatError,
    asf_path,
    file_format,
    load_amc,
    load_asf,
    load_bvh,
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
    with pytest.raises(MocapFormatError):
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


@pytest.mark.parametrize("kept", [20, 100, 200, 300])
def test_damaged_compression(kept, tmp_path):
    whole = gzip.compress(BVH.read_bytes())
    (tmp_path / "cut.gz").write_bytes(whole[:kept])
    damaged = bytearray(whole)
    damaged[kept] ^= 0xFF
    (tmp_path / "damaged.gz").write_bytes(damaged)
    with pytest.raises(MocapFormatError):
        load_bvh(tmp_path / "cut.gz")
    with pytest.raises(MocapFormatError):
        load_bvh(tmp_path / "damaged.gz")
    (tmp_path / "other.bz2").write_bytes(bz2.compress(BVH.read_bytes()))
    with pytest.raises(MocapFormatError):
        load_bvh(tmp_path / "other.bz2")
