"""Files of compiled functions that several processes write: each process finds what it looks for, or nothing."""

import pytest

from skpose._compiled.simd.cache import CodeFiles

SINGLE, DOUBLE = "float32(float32)", "float64(float64)"


@pytest.fixture
def process(tmp_path):
    """What a process has of the files of one function, for sources with this digest."""

    def files(digest="a"):
        file = CodeFiles(str(tmp_path), "module.function-1.py3", 0)
        file._version += digest
        return file

    return files


def test_what_is_saved_is_loaded(process):
    process().save(SINGLE, ("code", 1))
    process().save(DOUBLE, ("code", 2))
    assert process().load(SINGLE) == ("code", 1)
    assert process().load(DOUBLE) == ("code", 2)
    assert process().load("int64(int64)") is None
    assert process("b").load(SINGLE) is None  # of other sources
