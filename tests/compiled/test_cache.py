"""Files of compiled functions that several processes write: each process finds what it looks for, or nothing."""

import numba
import pytest
from numba.core.caching import IndexDataCacheFile

from skpose._compiled.simd.cache import KeyedFile

SINGLE, DOUBLE = "float32(float32)", "float64(float64)"


@pytest.fixture
def process(tmp_path):
    """What a process has of the files of one function, for sources with this digest."""

    def files(digest="a"):
        file = KeyedFile(str(tmp_path), "module.function-1.py3", 0)
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


def test_processes_that_compile_for_other_types_at_a_time_never_load_each_others_code(process, monkeypatch):
    """Both read the index before the other one writes it."""
    one, other, third = process(), process(), process()
    third.save("int64(int64)", "third")
    before = one._load_index()
    monkeypatch.setattr(one, "_load_index", lambda: dict(before))
    monkeypatch.setattr(other, "_load_index", lambda: dict(before))
    writes = one._save_data

    def late(name, data):  # the index of one, all of the other, and then the data of one
        other.save(DOUBLE, "double")
        writes(name, data)

    monkeypatch.setattr(one, "_save_data", late)
    one.save(SINGLE, "single")
    assert process().load(DOUBLE) == "double"
    assert process().load(SINGLE) is None  # compiled again, as the index of the other has no place for it
    process().save(SINGLE, "single")
    found = [process().load(key) for key in (SINGLE, DOUBLE, "int64(int64)")]
    assert found == ["single", "double", "third"]


def test_numbas_own_files_still_have_these_faults(tmp_path, monkeypatch):
    """When this fails, numba has mended them, and `KeyedFile` can go."""
    files = [IndexDataCacheFile(str(tmp_path), "module.function-1.py3", 0) for _ in range(2)]
    for file in files:
        monkeypatch.setattr(file, "_load_index", dict)
    writes = files[0]._save_data
    monkeypatch.setattr(files[0], "_save_data", lambda *data: (files[1].save(DOUBLE, "double"), writes(*data)))
    files[0].save(SINGLE, "single")
    found = IndexDataCacheFile(str(tmp_path), "module.function-1.py3", 0).load(DOUBLE)
    assert found == "single", f"numba {numba.__version__} keeps them apart"
