import re

import numpy as np
import pytest
from matplotlib.image import imread
from scipy.stats import mannwhitneyu

from skpose import geodesic, pose_distances
from skpose._cli import report, reproduce
from skpose._cli.main import main
from skpose.datasets import make_gait, walks_and_runs

PAPER = {"0.94", "40 %", "80 %", "< 1e-6", "90 %", "100 %", "60 %", "65 %"}


@pytest.fixture(scope="module")
def gait():
    return make_gait(n_subjects=3, n_sequences=2, duration=2, random_state=0)


@pytest.fixture(autouse=True)
def few_draws(monkeypatch):
    monkeypatch.setattr(reproduce, "N_DRAWS", 2)
    monkeypatch.setattr(reproduce, "N_PAIRS", 4)
    monkeypatch.setattr(reproduce, "N_SEQUENCES", 2)


@pytest.fixture(scope="module")
def findings(gait):
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"N_DRAWS": 2, "N_PAIRS": 4, "N_SEQUENCES": 2}.items():
            patch.setattr(reproduce, name, value)
        return reproduce.reproduce(gait, seed=3)


def row(findings, what):
    (found,) = (row for row in findings.rows if row.what == what)
    return found


def test_every_number_of_section_3_is_there(findings):
    assert {row.paper for row in findings.rows} >= PAPER
    assert {row.section[:3] for row in findings.rows} == {"3.1", "3.2", "3.3", "3.4"}
    for row in findings.rows:
        assert row.first
        assert row.n_sequences > 0
        assert row.n_poses > 0
    assert all(note.endswith(".") and "\n" not in note for note in reproduce.DIFFERENCES)


def test_the_seed_decides(gait, findings):
    assert reproduce.reproduce(gait, seed=3, n_jobs=2).rows == findings.rows
    assert reproduce.reproduce(gait, seed=4).rows != findings.rows


def test_ratios_are_those_of_the_geodesics(findings):
    skeleton, a, b = findings.pair
    line = pose_distances([a], [b], skeleton=skeleton)[0, 0]
    np.testing.assert_allclose(findings.ratios.min(), min(geodesic(a, b, skeleton).length / line, 1))
    assert row(findings, "r, lowest of 100 pairs").first == f"{findings.ratios.min():.3f}"


def test_the_test_of_figure_4_c_is_scipys(findings):
    test = mannwhitneyu(findings.shares["spatial"], findings.shares["angle"], alternative="greater")
    assert row(findings, "spatial holds more than angle, p").first == f"{test.pvalue:.1e}"
    for shares in findings.shares.values():
        assert ((shares > 0) & (shares <= 1)).all()


@pytest.mark.parametrize("metric", reproduce.METRICS)
def test_classification_by_hand(gait, findings, metric):
    """The nearest pose among the other sequences of the draw, one sequence at a time."""
    chosen = np.concatenate(list(findings.draws[0].values()))
    gait = walks_and_runs(gait)
    X, sequence = gait.poses(12)
    right = []
    for left_out in chosen:
        rest = np.isin(sequence, chosen) & (sequence != left_out)
        D = pose_distances(X[sequence == left_out], X[rest], skeleton=gait.skeleton, metric=metric)
        nearest = D.argmin(axis=1)
        right += list(gait.actions[sequence[rest][nearest]] == gait.actions[left_out])
    assert row(findings, f"poses classified right, leave one sequence out, {metric}").first == f"{np.mean(right):.1%}"


def test_draws_are_walks_and_runs_and_none_twice(gait, findings):
    gait = walks_and_runs(gait)
    for draw in findings.draws:
        for action, chosen in draw.items():
            assert len(set(chosen)) == 2
            assert set(gait.actions[chosen]) == {action}


def test_one_person_alone(gait):
    alone = gait.select(gait.subjects == gait.subjects[0])
    findings = reproduce.reproduce(alone)
    assert any("Only one person" in note for note in findings.notes)
    assert not any("fig. 4 (a, b)" in row.section or "person" in row.what for row in findings.rows)
    assert "Only one person moves" in report.text(findings)


def test_without_runs_there_is_a_word(gait):
    with pytest.raises(ValueError, match="none has an action that begins with 'run'"):
        reproduce.reproduce(gait.select(gait.actions == "walk"))


def test_the_command_writes_the_table_and_the_figures(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(
        "skpose._cli.commands.make_gait", lambda random_state: make_gait(3, 2, duration=2, random_state=random_state)
    )
    assert main(["reproduce", "--out", str(tmp_path / "out"), "--jobs", "1"]) == 0
    printed = capsys.readouterr().out
    document = (tmp_path / "out" / "README.md").read_text(encoding="utf-8")
    for value in PAPER:
        assert value in printed
        assert f"| {value} |" in document
    table = [line for line in document.splitlines() if line.startswith("|")]
    assert len({line.count("|") for line in table}) == 1
    for name in re.findall(r"\]\((.*\.png)\)", document):
        picture = imread(tmp_path / "out" / name)
        assert min(picture.shape[:2]) > 300
        assert np.ptp(picture[..., :3]) == 1  # black and white at least
    assert (tmp_path / "out" / "table.txt").read_text(encoding="utf-8").split() == printed.split("Written to")[
        0
    ].split()


def test_without_matplotlib_the_command_says_so_at_once(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("skpose._cli.commands.find_spec", lambda name: None)
    assert main(["reproduce", "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err == "skpose: the figures need matplotlib: pip install 'skpose[plot]'\n"
    assert not (tmp_path / "out").exists()


def test_on_cmu_files_figure_4_c_is_the_papers(cmu):
    findings = reproduce.Findings()
    reproduce._components(findings, cmu, walks_and_runs(cmu), None, None)
    modes = [float(row.first.rstrip("%")) for row in findings.rows[:2]]
    np.testing.assert_allclose(modes, [40, 80], atol=5)
    assert float(findings.rows[2].first) < 1e-6
