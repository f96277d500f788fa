"""TRC files: what is read, and what is refused with line, column and remedy."""

import gzip
import io

import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, load_trc

TRC = damaged.trc_file().decode()
POSITIONS = damaged.positions()
HEAD = 6  # lines above the first frame


def changed(line, change):
    """Return the file with a line, from 1, changed by a function of its cells."""
    lines = TRC.split("\n")
    lines[line - 1] = "\t".join(change(lines[line - 1].split("\t")))
    return io.StringIO("\n".join(lines))


def cell(line, column, text):
    """Return the file with another text in a cell; the column is counted from 1."""
    return changed(line, lambda cells: [*cells[: column - 1], text, *cells[column:]])


def line_refused(file, **options):
    with pytest.raises(MocapFormatError) as caught:
        load_trc(file, **options)
    return caught.value.line


def test_positions_names_and_rate():
    markers = load_trc(io.StringIO(TRC))
    np.testing.assert_allclose(markers.positions, POSITIONS / 1000, atol=1e-8)  # five digits of mm
    assert (markers.names, markers.frame_rate, markers.up) == (("hip", "knee", "ankle"), 100.0, "y")
    np.testing.assert_array_equal(markers.confidences, ~np.isnan(POSITIONS).any(axis=2))
    assert load_trc(io.StringIO(TRC), up="z").up == "z"


@pytest.mark.parametrize(
    "data",
    [
        gzip.compress(TRC.encode()),
        b"\xef\xbb\xbf" + TRC.encode(),
        TRC.replace("\n", "\r\n").encode(),
        TRC.replace("\n", "\r").encode(),
        TRC.replace("\n\n", "\n").encode(),  # no blank line below the head
        TRC.rstrip("\n").encode(),
        TRC.replace("\n", "\t\n").encode(),
        TRC.replace("\t\t\t\t", "\tNaN\tNaN\tnan\t").encode(),
        TRC.replace("\t\t\t\t", "\t \t \t \t").encode(),
    ],
    ids=["gzip", "BOM", "CRLF", "CR", "no blank line", "no end", "tab at the end", "NaN", "blanks"],
)
def test_forms_of_one_file(data, tmp_path):
    (tmp_path / "walk.trc").write_bytes(data)
    expected = load_trc(io.StringIO(TRC))
    for file in (tmp_path / "walk.trc", str(tmp_path / "walk.trc"), io.BytesIO(data)):
        np.testing.assert_array_equal(load_trc(file).positions, expected.positions)
    assert np.isnan(expected.positions).sum() == 9  # three frames of one marker


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("cm", 0.01), ("Meters", 1.0), ("ft", 0.3048)],
)
@pytest.mark.filterwarnings("ignore:.* m from end to end in the median frame:UserWarning")
def test_units_are_the_files_own_word(unit, metres):
    markers = load_trc(cell(3, 5, unit))
    np.testing.assert_allclose(markers.positions, POSITIONS * metres, atol=1e-5 * metres)


def test_the_number_of_rows():
    for count in ("19", "21", "1000000000000"):
        assert line_refused(cell(3, 3, count)) == 3
        assert len(load_trc(cell(3, 3, count), trust="rows")) == 20
    empty = "\n".join(TRC.split("\n")[:5]).replace("\t20\t", "\t0\t")
    assert len(load_trc(io.StringIO(empty))) == 0


def test_a_missing_cell_is_not_a_lost_marker():
    assert line_refused(changed(9, lambda cells: cells[:-1])) == 9
    # A cell too many and one too few: the row is as wide as the others.
    assert line_refused(changed(9, lambda cells: [*cells[:5], "", *cells[5:-1]])) == 9
    # At blanks the cells of a lost marker cannot be seen.
    assert line_refused(io.StringIO(TRC.replace("\t", " "))) == HEAD + 4


@pytest.mark.parametrize(
    ("file", "line"),
    [
        (cell(8, 4, "1,5"), 8),
        (cell(8, 4, "1_0"), 8),
        (cell(8, 1, ""), 8),
        (cell(8, 1, "7"), 8),
        (cell(1, 1, "hello"), 1),
        (cell(3, 1, "-1"), 3),
        (cell(5, 3, "X1\tY1\tZ1\tX1"), 4),
        (cell(2, 5, "Unit"), 3),
        (cell(4, 2, "seconds"), 4),
        (cell(5, 4, "Z1"), 5),
        (cell(3, 5, "parsec"), 3),
    ],
)
def test_what_is_refused(file, line):
    assert line_refused(file) == line


def at_rate(rate):
    """Return the file with times at another rate than the 100 Hz of its head."""
    lines = TRC.rstrip("\n").split("\n")
    for i in range(HEAD - 1, len(lines)):
        cells = lines[i].split("\t")
        if len(cells) > 2:
            lines[i] = "\t".join([cells[0], f"{(int(cells[0]) - 1) / rate + 7:.3f}", *cells[2:]])
    return io.StringIO("\n".join(lines))


def test_times_that_contradict_the_rate():
    assert load_trc(at_rate(100)).frame_rate == 100  # from 7 s on
    assert load_trc(at_rate(100.5)).frame_rate == 100
    with pytest.raises(MocapFormatError):
        load_trc(at_rate(110))
    assert load_trc(at_rate(50), frame_rate=50).frame_rate == 50
