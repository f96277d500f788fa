"""TRC files as public programs write them: separators, columns, counts and rates; each is read as the plain file is."""

import io

import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, load_trc

SEEN = np.nan_to_num(damaged.positions(), nan=123.0)
TRC = damaged.trc_file(points=SEEN).decode()
LOST = damaged.trc_file().decode()
HEAD = 6  # lines above the first frame


def lines_of(text):
    return text.rstrip("\n").split("\n")


def joined(lines):
    return "\n".join(lines) + "\n"


def replaced(text, line, old, new):
    """Return a file with something else in one line, from 1, where it must be."""
    lines = lines_of(text)
    assert old in lines[line - 1]
    lines[line - 1] = lines[line - 1].replace(old, new)
    return joined(lines)


def load(text, **options):
    return load_trc(io.StringIO(text), **options)


def two_tabs(text):
    """Return the form of some MATLAB scripts: `Times`, names two tabs apart, the axes one column to the right."""
    lines = lines_of(text)
    lines[3] = "Frame#\tTimes\t\t" + "\t\t".join(damaged.NAMES)
    lines[4] = "\t" + lines[4].rstrip("\t")
    return joined(lines)


@pytest.mark.parametrize("text", [LOST])
@pytest.mark.parametrize(
    "change",
    [
        lambda text: replaced(text, 1, "PathFileType\t4\t(X/Y/Z)\t", "PathFileType  4\t(X/Y/Z) C:\\some where\\"),
        lambda text: replaced(replaced(text, 2, "\t", " "), 3, "\t", "   "),
        lambda text: replaced(replaced(text, 2, "\t", "\t\t"), 3, "\t", " \t"),
        lambda text: replaced(text, 3, "\t20\t", "\t       20\t"),
        lambda text: replaced(text, 4, "Time", "Time  "),
        lambda text: replaced(text, 4, "Frame#\tTime\t", "Frame#  Time   "),
        two_tabs,
        lambda text: joined(lines_of(text)[:4] + lines_of(text)[5:]),
        lambda text: joined([*lines_of(text)[:4], *lines_of(text)[6:]]),
        lambda text: text.replace("\n", "\t\t\t\n"),
        lambda text: replaced(text, 5, "\t\tX1", "X1"),
        lambda text: text + "\n\t\t\t\t\n   \n" + "\t" * 11,
        lambda text: text.replace("\t", ","),
    ],
    ids=["first line at blanks", "keys at blanks", "keys at tabs and blanks", "blanks before a count",
         "blanks after Time", "columns at blanks", "two tabs", "no line of axes", "no line of axes, no blank one",
         "tabs at all ends",
         "axes at the left", "blank rows", "commas"],
)  # fmt: skip
def test_heads_and_rows(text, change):
    expected, changed = load(text), change(text)
    assert changed != text
    for markers in (load(changed), load(changed.replace("\n", "\r\n"))):
        np.testing.assert_array_equal(markers.positions, expected.positions)
        assert (markers.names, markers.frame_rate) == (expected.names, expected.frame_rate)


@pytest.mark.parametrize("separator", [" ", "   ", " \t "])
def test_all_cells_at_blanks(separator):
    """Where no cell is empty."""
    np.testing.assert_array_equal(load(TRC.replace("\t", separator)).positions, load(TRC).positions)


def test_names_with_blanks_in_them_are_separated_by_tabs():
    text = replaced(TRC, 4, "hip\t\t\tknee", "left hip\t\t\tthe knee")
    assert load(text).names == ("left hip", "the knee", "ankle")
    assert load(replaced(TRC, 4, "\t\t\t", "  ")).names == ("hip", "knee", "ankle")
    one = damaged.trc_file(points=SEEN[:, :1], names=["end effector"]).decode()
    assert load(one).names == ("end effector",)


def test_names_without_columns_are_left_out():
    text = replaced(TRC, 4, "ankle", "ankle\t\t\tV_hip\t\t\tV_hip\t\t\tV toe")
    text = joined(lines_of(text)[:6] + [row + "\t" * 9 for row in lines_of(text)[6:]])
    with pytest.warns(UserWarning, match="names 6 markers"):
        markers = load(text)
    assert markers.names == ("hip", "knee", "ankle")
    np.testing.assert_array_equal(markers.positions, load(TRC).positions)


@pytest.mark.parametrize("count", ["2", "4"])
def test_a_wrong_number_of_markers(count):
    """Names and columns agree."""
    with pytest.warns(UserWarning, match=f"NumMarkers is {count}"):
        np.testing.assert_array_equal(load(replaced(TRC, 3, "\t3\t", f"\t{count}\t")).positions, load(TRC).positions)


def test_numbers_without_a_frame_below_the_last_one():
    """A spreadsheet's sums, say."""
    text = LOST + "\t" * 5 + "127.9\t\t\n" + "\t" * 5 + "54.1\n"
    with pytest.warns(UserWarning, match="2 rows"):
        np.testing.assert_array_equal(load(text).positions, load(LOST).positions)
    lines = lines_of(TRC)
    between = joined([*lines[: HEAD + 3], "\t" * 5 + "1.5" + "\t" * 5, *lines[HEAD + 3 :]])
    with pytest.raises(MocapFormatError):
        load(between)


def at_rate(rate, text=TRC):
    lines = lines_of(text)
    for k in range(20):
        cells = lines[HEAD + k].split("\t")
        lines[HEAD + k] = "\t".join([cells[0], f"{k / rate:.6f}", *cells[2:]])
    return joined(lines)


def test_a_rate_of_zero_is_that_of_the_times():
    text = replaced(at_rate(90.69), 3, "100.00\t100.00", "0.000\t0")
    with pytest.warns(UserWarning, match="DataRate is 0"):
        assert load(text).frame_rate == pytest.approx(90.69, rel=1e-4)
    with pytest.warns(UserWarning, match="frame_rate=50 replaces"):
        assert load(text, frame_rate=50).frame_rate == 50
    with pytest.raises(MocapFormatError):
        load(replaced(joined(lines_of(text)[: HEAD + 1]), 3, "\t20\t", "\t1\t"))


@pytest.mark.parametrize("time", ["Time (s)", "Time [sec]", "Time/s"])
def test_a_unit_of_time_is_no_marker(time):
    """It moved all names by one, so that each marker had its neighbour's."""
    found = load(replaced(LOST, 4, "Time", time))
    assert found.names == load(LOST).names
    np.testing.assert_array_equal(found.positions, load(LOST).positions)


def test_a_marker_without_a_name_is_called_by_its_number():
    text = replaced(TRC, 4, "knee", " ")
    with pytest.warns(UserWarning, match="numbers"):
        found = load(text)
    assert found.names == ("hip", "2", "ankle")
    np.testing.assert_array_equal(found.positions, load(TRC).positions)
