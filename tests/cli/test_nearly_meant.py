"""Words that a command does not know: commands, options, choices, files; and the command without any."""

from pathlib import Path

import pytest

from skpose._cli.main import main


def error_of(arguments, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    return capsys.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["explor", "a.bvh"], "'warm-up'): did you mean 'explore'?"),
        (["distances", "a.bvh", "--metric", "spacial", "--out", "D.npy"], "'geodesic'): did you mean 'spatial'?"),
        (["distances", "a.bvh", "--metrik=spatial", "--out", "D.npy"], "no option --metrik: did you mean --metric?"),
        (["neighbors", "a.bvh", "--radis", "3", "--out", "G.npz"], "there is no option --radis: did you mean --radius"),
        (["info", "a.bvh", "--qqq"], "skpose info: error: there is no option --qqq: skpose info --help lists all"),
    ],
)
def test_the_nearest_word_is_named(arguments, words, capsys):
    assert words in error_of(arguments, capsys)


def test_what_is_near_to_nothing_gets_the_choices_alone(capsys):
    assert error_of(["qqq"], capsys).endswith("'warm-up')")


def test_without_a_command_there_is_help(capsys):
    assert main([]) == 0
    printed = capsys.readouterr()
    assert printed.out.startswith("usage: skpose")
    assert "explore" in printed.out
    assert not printed.err


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("walk2.bvh", "skpose: there is no file walk2.bvh: did you mean 'walk.bvh'?"),
        ("qqq", "skpose: there is no file qqq, nor one with a similar name"),
        (str(Path("folder", "a.bvh")), f"skpose: there is no file {Path('folder', 'a.bvh')}, as there is no folder f"),
    ],
)
def test_a_file_that_is_not_there(name, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("walk.bvh").touch()
    assert main(["info", name]) == 1
    assert words in capsys.readouterr().err
