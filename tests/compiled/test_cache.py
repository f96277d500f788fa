"""Files of compiled functions that several processes write: each process finds what it looks for, or nothing."""

import numpy as np
import pytest
from numba import config, njit

from skpose._compiled.simd.cache import Cache, CodeFiles

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
    process().flush()
    assert process().load(SINGLE) is None


DAMAGE = {
    "empty": lambda content: b"",
    "truncated": lambda content: content[: len(content) // 2],
    "zeroed": lambda content: bytes(len(content)),
    "garbled": lambda content: content[:-1] + bytes([content[-1] ^ 1]),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_damaged_files_are_compiled_anew(process, tmp_path, damage):
    process().save(SINGLE, "code")
    (path,) = tmp_path.iterdir()
    path.write_bytes(damage(path.read_bytes()))
    assert process().load(SINGLE) is None
    process().save(SINGLE, "code")
    assert process().load(SINGLE) == "code"


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
@pytest.mark.filterwarnings("error")
def test_a_cache_that_cannot_be_written_stops_no_call(tmp_path, monkeypatch):
    def twice(x):
        return 2.0 * x

    compiled = njit(twice)
    compiled._cache = Cache(twice, "digest", lambda function: None)
    monkeypatch.setattr(compiled._cache._cache_file, "_cache_path", str(tmp_path / "missing"))
    with pytest.warns(UserWarning, match="cache"):
        assert compiled(np.float64(2.0)) == 4.0
