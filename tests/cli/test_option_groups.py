"""Options are in the same groups, in the same order, for every command."""

import argparse

import pytest

from skpose._cli.options import GROUPS
from skpose._cli.parser import command_line

ALWAYS = {"--metric": "metric", "--out": "output", "--jobs": "computation", "--scale": "reading", "--up": "reading"}
ALWAYS |= {"--skip-errors": "reading", "--rotations": "preparing", "--retarget": "preparing", "--window": "metric"}


def commands():
    """Return the parser of each command by its name."""
    (choices,) = (one.choices for one in command_line()._actions if isinstance(one, argparse._SubParsersAction))
    return choices


@pytest.mark.parametrize("name", commands())
def test_every_option_is_in_a_group(name):
    groups = {group.title: group._group_actions for group in commands()[name]._action_groups}
    assert tuple(groups)[-len(GROUPS) :] == GROUPS
    assert [option for one in groups["options"] for option in one.option_strings] == ["-h", "--help"]
    for title in GROUPS:
        for one in groups[title]:
            assert one.help
            for option in one.option_strings:
                assert ALWAYS.get(option, title) == title


@pytest.mark.parametrize("name", commands())
def test_a_command_that_reads_several_files_may_leave_out_some(name):
    parser = commands()[name]
    several = any(one.dest == "files" for one in parser._actions)
    options = {option for one in parser._actions for option in one.option_strings}
    assert ("--skip-errors" in options) == (several and name != "between")  # whose frames are one of each file
