"""What gzip and zip may hold, and pipes and links in the place of files."""

import gzip
import io
import os
import struct
import threading
import time
import tracemalloc
import zipfile
import zlib
from contextlib import contextmanager

import damaged
import mutations
import numpy as np
import pytest
from conftest import DATA

from skpose.io import (
    MocapFormatError,
    _opening,
    asf_path,
    file_format,
    load_amass,
    load_amc,
    load_asf,
    load_bvh,
    load_c3d,
    load_keypoints,
    load_motion,
    load_trc,
)  # fmt: skip

BVH, ASF, AMC = mutations.BVH, mutations.ASF, mutations.AMC
LEAST = 500_000
TOO_MUCH = (
    r"{}: its gzip compression holds more than \d+ MB, over 100 times its size, which no recording does; .* gunzip"
)


@pytest.fixture
def less(monkeypatch):
    """A smaller limit, for smaller files."""
    monkeypatch.setattr(_opening, "LEAST", LEAST)


@contextmanager
def bounded_memory(most):
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()


LOADERS = {
    "bvh": (load_bvh, BVH, {}),
    "amc": (load_amc, AMC, {"asf": ASF, "frame_rate": 60}),
    "asf": (load_asf, ASF, {}),
    "trc": (load_trc, damaged.trc_file(), {}),
    "c3d": (load_c3d, damaged.c3d_kinds()[0], {}),
    "npy": (load_keypoints, damaged.FILES["NPY"][0], {"names": damaged.NAMES, "frame_rate": 25, "scale": 0.001}),
    "motion": (load_motion, BVH, {}),
}


@pytest.mark.filterwarnings("ignore:.* from end to end")
@pytest.mark.parametrize(
    ("name", "filling"),
    [
        *((name, b" ") for name in LOADERS),
        pytest.param("amc", b"\n", marks=pytest.mark.slow),
        ("bvh", b"0 "),
        ("c3d", b"\0"),
        ("npy", b"\0"),
    ],
)
def test_what_gzip_holds_is_limited(name, filling, less, tmp_path):
    """Behind a file that is read without the filling, on one line or on many."""
    load, data, options = LOADERS[name]

    def read(file):
        load(file, **{key: io.BytesIO(ASF) if key == "asf" else value for key, value in options.items()})

    path = tmp_path / f"a.{name}.gz"
    path.write_bytes(gzip.compress(data))
    read(path)
    path.write_bytes(gzip.compress(data + filling * (20_000_000 // len(filling)), 1))
    with (
        bounded_memory(8_000_000 if filling != b"\n" else 30_000_000),
        pytest.raises(MocapFormatError, match=TOO_MUCH.format(path.name)),
    ):
        read(path)
    with path.open("rb") as file, pytest.raises(MocapFormatError, match=TOO_MUCH.format(path.name)):
        read(file)


@pytest.mark.slow
def test_the_limit_is_64_megabytes():
    """Of a file of 100 kB that holds 100 MB; the format of a file is found without unpacking it."""
    bomb = gzip.compress(BVH + b" " * (100 << 20))
    assert len(bomb) < 200_000
    with bounded_memory(3 << 26), pytest.raises(MocapFormatError, match=TOO_MUCH.format("the open file")):
        load_bvh(io.BytesIO(bomb))
    with bounded_memory(3 << 20):
        assert file_format(io.BytesIO(bomb)) == "BVH"


@pytest.mark.filterwarnings("ignore:the open file. the skeleton is")
def test_recordings_are_below_the_limit(less):
    """A hundred times the size is enough for numbers, and the least for a short file of a person who does not move."""
    head, frames = BVH.split(b"Frames: 2\n")
    rng, width = np.random.default_rng(0), len(frames.splitlines()[1].split())
    for rows in (rng.normal(size=(3000, width)), np.tile(rng.normal(size=width), (1500, 1))):
        text = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in rows).encode()
        data = head + b"Frames: %d\nFrame Time: 0.01\n" % len(rows) + text
        packed = gzip.compress(data)
        assert len(data) > LEAST or len(data) > 30 * len(packed)
        np.testing.assert_array_equal(load_bvh(io.BytesIO(packed)).angles, load_bvh(io.BytesIO(data)).angles)


def entry(shape, data=None):
    """An array of zeros, or of these data, as in an archive."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return file.getvalue() + (bytes(8 * int(np.prod(shape))) if data is None else data)


def archive(entries, compression=zipfile.ZIP_DEFLATED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", compression) as archive:
        for key, data in entries.items():
            archive.writestr(f"{key}.npy", data)
    return file.getvalue()


@pytest.mark.filterwarnings("ignore:bones have the lengths")
@pytest.mark.parametrize("claim", [None, 2**31], ids=["as it is", "a larger size is claimed"])
def test_what_an_archive_holds_is_limited(claim, less):
    n = 5_000
    rest = {"trans": entry((n, 3)), "mocap_framerate": entry((), struct.pack("<d", 60.0))}
    data = archive({"poses": entry((n, 72)), **rest})
    if claim:  # of the packed entry, in the table of contents
        at = data.index(b"PK\x01\x02") + 20
        data = data[:at] + struct.pack("<I", claim) + data[at + 4 :]
    message = r"the open file: poses: its compression holds 2 MB, over 100 times its size, which no .* numpy\.savez"
    with bounded_memory(2 * LEAST), pytest.raises(MocapFormatError, match=message):
        load_amass(io.BytesIO(data))
    keypoints = archive({"positions": entry((n, 24, 3))})
    with bounded_memory(2 * LEAST), pytest.raises(MocapFormatError, match="positions: its compression holds"):
        load_keypoints(io.BytesIO(keypoints), names=[f"p{i}" for i in range(24)], frame_rate=30)
    stored = archive({"poses": entry((n, 72)), **rest}, zipfile.ZIP_STORED)  # as the message advises
    assert len(load_amass(io.BytesIO(stored), up="y")) == n


def test_a_stream_without_an_end_is_limited(less):
    """Of which no file states the length; here it ends after a thousand times the limit, so that the test does."""

    class Endless(io.RawIOBase):
        def __init__(self):
            self._packer, self._left = zlib.compressobj(wbits=31), b""
            self._next, self._n_left = BVH, 1000 * LEAST

        def readable(self):
            return True

        def readinto(self, buffer):
            while not self._left and self._n_left > 0:
                self._left = self._packer.compress(self._next)
                self._next = b" " * 1_000_000
                self._n_left -= len(self._next)
            n = min(len(buffer), len(self._left))
            buffer[:n], self._left = self._left[:n], self._left[n:]
            return n

    with pytest.raises(MocapFormatError, match=TOO_MUCH.format("the open file")):
        load_bvh(Endless())


# Pipes and links

needs_pipes = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")


@needs_pipes
def test_a_pipe_that_nobody_writes_to_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr(_opening, "PATIENCE", 0.05)
    for name in ("a.bvh", "walk.asf"):
        os.mkfifo(tmp_path / name)
    (tmp_path / "walk.amc").write_bytes(AMC)
    nobody = r"{} is a named pipe that no program writes to: start the program that does, or pass a file"
    for load, path, name in (
        (load_bvh, tmp_path / "a.bvh", r"a\.bvh"),
        (load_asf, tmp_path / "walk.asf", r"walk\.asf"),
        (load_motion, tmp_path / "walk.amc", r"walk\.asf"),  # which it finds by the name
        (lambda path: load_amc(path, tmp_path / "walk.asf", frame_rate=60), tmp_path / "walk.amc", r"walk\.asf"),
    ):
        started = time.monotonic()
        with pytest.raises(TimeoutError, match=nobody.format(name)):
            load(path)
        assert time.monotonic() - started < 5


@needs_pipes
@pytest.mark.filterwarnings("ignore:.* from end to end")
@pytest.mark.parametrize("delay", [0.0, 0.1], ids=["at once", "later"])
@pytest.mark.parametrize("data", [BVH, gzip.compress(BVH), BVH + b"\n" * 300_000], ids=["text", "gzip", "large"])
def test_a_pipe_that_a_program_writes_to_is_read(data, delay, tmp_path):
    """Also where the program opens it later, writes later, or writes more than a pipe holds."""
    path = tmp_path / "a.bvh"
    os.mkfifo(path)

    def write():
        time.sleep(delay)
        with path.open("wb") as file:
            file.flush()
            time.sleep(delay)
            file.write(data)

    writer = threading.Thread(target=write)
    writer.start()
    try:
        motion = load_bvh(path)
    finally:
        writer.join()
    np.testing.assert_array_equal(motion.angles, load_bvh(io.BytesIO(BVH)).angles)


def test_links_in_the_place_of_a_skeleton(tmp_path):
    (tmp_path / "loop.amc").write_bytes(AMC)
    os.symlink("loop.asf", tmp_path / "loop.asf")
    with pytest.raises(OSError, match=r"symbolic links.*loop\.asf"):
        load_motion(tmp_path / "loop.amc", frame_rate=60)
    with pytest.raises(OSError, match=r"symbolic links"):
        load_asf(tmp_path / "loop.asf")
    (tmp_path / "none.amc").write_bytes(AMC)
    os.symlink("nowhere", tmp_path / "none.asf")
    with pytest.raises(FileNotFoundError, match=r"none\.asf"):
        load_motion(tmp_path / "none.amc", frame_rate=60)


def test_a_link_to_an_amc_file_finds_the_skeleton_of_the_file(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "35.asf").write_bytes(ASF)
    (tmp_path / "data" / "35_01.amc").write_bytes(AMC)
    os.symlink(tmp_path / "data" / "35_01.amc", tmp_path / "walk.amc")
    assert asf_path(tmp_path / "walk.amc") == tmp_path / "data" / "35.asf"
    expected = load_motion(tmp_path / "data" / "35_01.amc", frame_rate=60)
    np.testing.assert_array_equal(load_motion(tmp_path / "walk.amc", frame_rate=60).angles, expected.angles)
    (tmp_path / "walk.asf").write_bytes((DATA / "arm.asf").read_bytes())
    assert asf_path(tmp_path / "walk.amc") == tmp_path / "walk.asf"  # one next to the link comes first
