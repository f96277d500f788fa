"""Terminals show help in 80 columns, colours where they have them, and what a command does at any moment."""

import argparse
import io
import re
import sys
import time

import pytest
from conftest import DATA

from skpose._cli import stages
from skpose._cli.colours import has_colours, paint_help
from skpose._cli.main import main
from skpose._cli.parser import SECTIONS, command_line
from skpose._cli.stages import show_stages, steps
from skpose._parallel.progress import progress, stage

ESCAPE = re.compile(r"\x1b\[[\d;]*[mK]")


class Terminal(io.StringIO):
    """A stream that is a terminal."""

    encoding = "utf-8"

    def isatty(self):
        return True

    def lines(self):
        """Return what is left to see, once every line that begins again has replaced the one before."""
        return [ESCAPE.sub("", line.rpartition("\r")[2]) for line in self.getvalue().split("\n")]

    def shown(self):
        """Return every picture of the last line."""
        return [ESCAPE.sub("", text) for text in re.split(r"[\r\n]", self.getvalue())]


def wait_for(terminal, text, patience=60.0):
    until = time.monotonic() + patience
    while text not in terminal.getvalue() and time.monotonic() < until:
        time.sleep(stages.TICK)


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")


def parsers():
    (choices,) = (one.choices for one in command_line()._actions if isinstance(one, argparse._SubParsersAction))
    return choices


@pytest.mark.parametrize("name", ["", *parsers()])
def test_help_fits_80_columns(name):
    text = (parsers()[name] if name else command_line()).format_help()
    assert max(map(len, text.splitlines())) <= 80
    assert text.splitlines()[1] == ""  # the usage is one line


def test_the_help_of_skpose_lists_every_command_once():
    listed = [name for names in SECTIONS.values() for name in names]
    assert sorted(listed) == sorted(parsers())
    found = re.findall(r"(?m)^  ([a-z][\w-]*)  ", command_line().format_help())
    assert found == listed


@pytest.mark.parametrize(
    ("variables", "terminal", "expected"),
    [
        ({}, True, True),
        ({}, False, False),
        ({"NO_COLOR": "1"}, True, False),
        ({"NO_COLOR": ""}, True, True),
        ({"FORCE_COLOR": "1"}, False, True),
        ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, True, False),
        ({"TERM": "dumb"}, True, False),
        ({"TERM": "dumb", "FORCE_COLOR": "1"}, True, True),
    ],
)
def test_where_there_are_colours(variables, terminal, expected, monkeypatch):
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert has_colours(Terminal() if terminal else io.StringIO()) == expected


def test_colours_change_no_word(monkeypatch):
    text = parsers()["explore"].format_help()
    painted = paint_help(text, Terminal())
    assert painted != text
    assert ESCAPE.sub("", painted) == text
    assert "\x1b[1moutput:\x1b[0m" in painted
    assert paint_help(text, io.StringIO()) == text


def test_an_error_is_red_in_a_terminal_and_plain_elsewhere(monkeypatch, capsys):
    assert main(["info", "qqq.bvh"]) == 1
    assert "\x1b" not in capsys.readouterr().err
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    assert main(["info", "qqq.bvh"]) == 1
    assert "\x1b[1;31mskpose:\x1b[0m there is no file qqq.bvh" in terminal.getvalue()


def test_a_terminal_shows_what_is_done_and_keeps_what_is_printed(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(sys, "stdout", terminal)
    with show_stages(), stage("skpose test"):
        with stage("loading"):
            pass
        for i in steps("reading 3 files", range(3)):
            print(f"file {i}")
            if i == 1:
                wait_for(terminal, " 33%")
        with stage("embedding"), progress("distances", 4, 0) as advance:
            advance()
    shown = terminal.shown()
    assert re.fullmatch(r"skpose test \d+\.\d s \.", shown[1])
    assert any(re.fullmatch(r"loading \d+\.\d s \.", text) for text in shown)
    assert any(re.match(r"reading 3 files ━+─+  33%", text) for text in shown)
    assert any(re.match(r"embedding: distances ─+   0%", text) for text in shown)
    assert [line for line in terminal.lines() if line] == ["file 0", "file 1", "file 2"]
    assert sys.stderr is terminal


def test_the_line_waits_for_the_end_of_another(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(sys, "stdout", terminal)
    with show_stages(), stage("work"):
        print("one, ", end="")
        time.sleep(3 * stages.TICK)
        print("two")
    assert "one, two" in terminal.lines()


def test_a_long_stage_leaves_a_line(monkeypatch):
    monkeypatch.setattr(stages, "LASTING", 0.0)
    monkeypatch.setattr(stages.time, "monotonic", lambda: 0.0)
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    with show_stages(), progress("outer", 2, 0), progress("inner", 2, 0):
        pass
    assert [line for line in terminal.lines() if line] == ["outer: done in 0.0 s"]


def test_elsewhere_there_is_a_line_for_each_long_stage(monkeypatch, capsys):
    with show_stages(), stage("work"), progress("outer", 2, 0), progress("inner", 2, 0):
        pass
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(stages, "LASTING", 0.0)
    monkeypatch.setattr(stages.time, "monotonic", lambda: 0.0)
    with show_stages(), stage("work"), progress("outer", 2, 0), progress("inner", 2, 0):
        pass
    assert capsys.readouterr().err == "outer: done in 0.0 s\n"


def test_a_dumb_terminal_gets_plain_lines(monkeypatch):
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    with show_stages(), stage("work"), progress("outer", 2, 0):
        pass
    assert terminal.getvalue() == ""


def test_a_command_that_fails_leaves_no_line(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    assert main(["view", str(DATA / "biped.bvh"), "none.bvh"]) == 1
    (line,) = (line for line in terminal.lines() if line)
    assert line.startswith("skpose: there is no file none.bvh")
