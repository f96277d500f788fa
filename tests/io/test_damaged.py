"""Damaged files of every format are read, or refused with the file's name; no other error is raised."""

import io

import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, load_amc, load_asf, load_keypoints, load_motion
from skpose.io._formats import format_of

ARRAYS = {"names": damaged.NAMES, "frame_rate": 25, "scale": 0.001}


def read(kind, data):
    """Read a file by the loader of its format."""
    if kind == "AMC":
        return load_amc(io.BytesIO(data), damaged.DATA / "arm.asf", frame_rate=60)
    if kind in ("NPY", "NPZ", "JSON", "CSV"):
        return load_keypoints(io.BytesIO(data), **ARRAYS)
    if kind in ("AMASS", "motion"):
        return load_motion(io.BytesIO(data))
    return load_asf(io.BytesIO(data)) if kind == "ASF" else format_of(io.BytesIO(data)).load(io.BytesIO(data))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", damaged.FILES)
def test_damaged_files(kind):
    rng, n_refused = np.random.default_rng(1), 0
    for _ in range(60):
        try:
            read(kind, damaged.damaged(kind, rng))
        except MocapFormatError:
            n_refused += 1
    assert n_refused > 10
