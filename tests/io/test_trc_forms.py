"""TRC files as public programs write them: separators, columns, counts and rates; each is read as the plain file is."""

import io

import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, file_format, load_trc

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


def refused(text, match, **options):
    with pytest.raises(MocapFormatError) as caught:
        load(text, **options)
    return caught.value


def two_tabs(text):
    """Return the form of some MATLAB scripts: `Times`, names two tabs apart, the axes one column to the right."""
    lines = lines_of(text)
    lines[3] = "Frame#\tTimes\t\t" + "\t\t".join(damaged.NAMES)
    lines[4] = "\t" + lines[4].rstrip("\t")
    return joined(lines)


@pytest.mark.parametrize("text", [TRC, LOST], ids=["all seen", "some lost"])
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
        lambda text: text.replace("\t", ",").replace("\n", ",,,,\n"),
    ],
    ids=["first line at blanks", "keys at blanks", "keys at tabs and blanks", "blanks before a count",
         "blanks after Time", "columns at blanks", "two tabs", "no line of axes", "no line of axes, no blank one",
         "tabs at all ends",
         "axes at the left", "blank rows", "commas", "more commas"],
)  # fmt: skip
def test_heads_and_rows(text, change, tmp_path):
    expected, changed = load(text), change(text)
    assert changed != text
    (tmp_path / "a.trc").write_text(changed)
    for markers in (load(changed), load_trc(tmp_path / "a.trc"), load(changed.replace("\n", "\r\n"))):
        np.testing.assert_array_equal(markers.positions, expected.positions)
        assert (markers.names, markers.frame_rate) == (expected.names, expected.frame_rate)
    assert file_format(tmp_path / "a.trc") == "TRC"


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
    for some in (text, joined(lines_of(text)[:4] + lines_of(text)[5:])):  # without the line of axes, too
        with pytest.warns(
            UserWarning,
            match="line 4 names 6 markers, but NumMarkers and the columns are those of 3: the names from 'V_h",
        ):
            markers = load(some)
        assert markers.names == ("hip", "knee", "ankle")
        np.testing.assert_array_equal(markers.positions, load(TRC).positions)


@pytest.mark.parametrize("count", ["2", "4", "0"])
def test_a_wrong_number_of_markers(count):
    """Names and columns agree."""
    text = replaced(TRC, 3, "\t3\t", f"\t{count}\t")
    for some in (text, joined(lines_of(text)[:4] + lines_of(text)[5:])):
        with pytest.warns(UserWarning, match=f"NumMarkers is {count}, but there are names and columns of 3 markers"):
            np.testing.assert_array_equal(load(some).positions, load(TRC).positions)


def test_numbers_without_a_frame_below_the_last_one():
    """A spreadsheet's sums, say."""
    text = LOST + "\t" * 5 + "127.9\t\t\n" + "\t" * 5 + "54.1\n"
    for options in ({}, {"trust": "rows"}):
        with pytest.warns(
            UserWarning, match=f"2 rows after the last frame, from line {HEAD + 21} on, have numbers but n"
        ):
            np.testing.assert_array_equal(load(text, **options).positions, load(LOST).positions)
    lines = lines_of(TRC)
    between = joined([*lines[: HEAD + 3], "\t" * 5 + "1.5" + "\t" * 5, *lines[HEAD + 3 :]])
    assert refused(between, "Frame#: expected a number, found ''").line == HEAD + 4
    assert refused(between, "expected a frame, found a row without Frame# and Time", trust="rows").line == HEAD + 4


def at_rate(rate, text=TRC):
    lines = lines_of(text)
    for k in range(20):
        cells = lines[HEAD + k].split("\t")
        lines[HEAD + k] = "\t".join([cells[0], f"{k / rate:.6f}", *cells[2:]])
    return joined(lines)


@pytest.mark.parametrize("zero", ["0", "0.000"])
def test_a_rate_of_zero_is_that_of_the_times(zero):
    text = replaced(at_rate(90.69), 3, "100.00\t100.00", f"{zero}\t0")
    with pytest.warns(
        UserWarning, match=r"DataRate is 0: 90.69 Hz is the rate of the column Time; frame_rate= chooses"
    ):
        assert load(text).frame_rate == pytest.approx(90.69, rel=1e-4)
    with pytest.warns(
        UserWarning, match="frame_rate=50 replaces the 90.69.* Hz of the column Time, so that it lasts 1.81 times"
    ):
        assert load(text, frame_rate=50).frame_rate == 50
    assert load(text, frame_rate=90.7).frame_rate == 90.7
    frozen = joined(
        [*lines_of(text)[:HEAD], *(row.replace(row.split("\t")[1], "0", 1) for row in lines_of(text)[HEAD:])]
    )
    refused(frozen, "DataRate is 0, and Time does not say the rate either: frame_rate= chooses it")
    one = replaced(joined(lines_of(text)[: HEAD + 1]), 3, "\t20\t", "\t1\t")
    refused(one, "DataRate is 0, and Time does not say the rate either: frame_rate= chooses it")
    lines = lines_of(text)
    lines[-1] = lines[-1].replace(lines[-1].split("\t")[1], "9")
    with pytest.warns(UserWarning, match="DataRate is 0"):
        refused(joined(lines), r"the mean rate is 2.1\d+ Hz, so frame 1 .* but Time says")


@pytest.mark.parametrize("text", [TRC, LOST], ids=["all seen", "some lost"])
@pytest.mark.parametrize(
    "time", ["Time (s)", "Time(s)", "Time [sec]", "time (ms) ", "TIME[s]", "Time s", "Time/s", "Times (s)"]
)
def test_a_unit_of_time_is_no_marker(text, time):
    """It moved all names by one, so that each marker had its neighbour's."""
    expected = load(text)
    between_blanks = replaced(text, 4, "Frame#\tTime\t", f"Frame#   {time}   ")
    for changed in [replaced(text, 4, "Time", time)] + [between_blanks] * ("(" in time or "[" in time):
        for form in (changed, changed.replace("\t", ",")):
            found = load(form)
            assert found.names == expected.names
            np.testing.assert_array_equal(found.positions, expected.positions)


@pytest.mark.parametrize("named", ["knee", "hip"])
def test_a_marker_without_a_name_is_called_by_its_number(named):
    empty = damaged.NAMES.index(named)
    text = replaced(TRC, 4, named, " ")
    assert "\t3\t" in lines_of(text)[2]
    with pytest.warns(UserWarning, match=f"line 4 has no name for 1 of 3 markers: they are called '{empty + 1}' here"):
        found = load(text)
    assert found.names == tuple(str(i + 1) if i == empty else name for i, name in enumerate(damaged.NAMES))
    np.testing.assert_array_equal(found.positions, load(TRC).positions)
    two_words = replaced(text, 4, "ankle", "left ankle")  # as many words as there are markers
    with pytest.warns(UserWarning, match="no name for 1 of 3"):
        assert load(two_words).names[2] == "left ankle"
