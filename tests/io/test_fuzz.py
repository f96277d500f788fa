"""Any bytes become a motion or a skeleton, or are refused with MocapFormatError, in memory that is bounded."""

import io
import tracemalloc
from contextlib import contextmanager

import damaged
import mutations
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from skpose.io import MocapFormatError, load_bvh, load_motion

# Bounds of the memory for a file: words become Python objects, some hundred bytes each.
MOST_BYTES, MOST_BYTES_PER_BYTE = 20_000_000, 200


@contextmanager
def bounded_memory(data):
    """Check the peak of memory; only here is it traced, as that makes Python four times as slow."""
    tracemalloc.start()
    try:
        yield
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < MOST_BYTES + MOST_BYTES_PER_BYTE * len(data), f"{peak:,} bytes for a file of {len(data):,}"


@settings(
    max_examples=200, deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow]
)
@given(mutations.files(), mutations.options)
def test_mutated_files(file, options):
    kind, data = file
    with bounded_memory(data):
        mutations.outcome(kind, data, options)


HEAD = b"HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n"
FOOT = b"MOTION\nFrames: 1\nFrame Time: 1\n"


@pytest.mark.filterwarnings(
    "ignore:the open file. joints in lines:UserWarning", "ignore:.* replaces the 120 Hz:UserWarning"
)
@pytest.mark.parametrize(
    "data",
    [
        mutations.BVH.replace(b"Frames: 2", b"Frames: 1000000000"),
        mutations.BVH.replace(b"Frames: 2", b"Frames: 999999999999999999"),
        mutations.BVH.replace(b"CHANNELS 3", b"CHANNELS 999999999"),
        HEAD + b"JOINT b\n{\n" * 10_000,
        HEAD + b"JOINT b\n{\nOFFSET 0 0 0\n" * 10_000 + b"}" * 10_001 + FOOT + b"1",
        b"{" * 100_000,
        b"1 " * 100_000,
        b"HIERARCHY " * 10_000,
        mutations.AMC + b"4\n" * 100_000,
        b":version\n" * 100_000,
        mutations.BVH + b"1 " * 100_000,
    ],
    ids=["gigabytes", "more than memory", "channels", "opened", "no dofs", "braces", "numbers", "words", "frames",
         "keywords", "more than stated"],
)  # fmt: skip
def test_memory_does_not_depend_on_counts_and_depth(data):
    with bounded_memory(data), pytest.raises(MocapFormatError):
        load_motion(io.BytesIO(data), asf=io.BytesIO(mutations.ASF), frame_rate=60)


@pytest.mark.filterwarnings("ignore:the open file. joints in lines:UserWarning")
def test_a_chain_ten_thousand_joints_deep_is_read():
    joint = b"JOINT b\n{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\n"
    data = HEAD + joint * 10_000 + b"}" * 10_001 + FOOT + b"1 " * 10_001
    motion = load_bvh(io.BytesIO(data))
    assert (motion.skeleton.n_joints, motion.skeleton.n_dofs) == (10_000, 10_000)


@pytest.mark.parametrize("kind", damaged.FILES)
def test_damaged_files_of_keypoints(kind):
    """Some of each kind are read: damage to a number, a name or what is left out."""
    rng = np.random.default_rng(0)
    files = [damaged.damaged(kind, rng) for _ in range(100 if kind in damaged.ARCHIVES else 400)]
    assert {damaged.outcome(kind, data) for data in damaged.FILES[kind]} == {"read"}
    outcomes = set()
    with bounded_memory(b"".join(files)[:100_000]):
        for data in files:
            outcomes.add(damaged.outcome(kind, data))
    assert outcomes == {"read", "refused"}
