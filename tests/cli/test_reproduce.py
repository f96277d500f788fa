"""`skpose reproduce`: its numbers against scipy and a computation by hand, its table and its figures."""

import re
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from scipy.stats import mannwhitneyu

from skpose import geodesic, pose_distances
from skpose._cli import report, reproduce
from skpose._cli.main import main
from skpose._cli.targets import REPORT
from skpose.datasets import make_gait, walks_and_runs

pytestmark = pytest.mark.slow
PAPER = {"0.94", "40 %", "80 %", "< 1e-6", "90 %", "100 %", "60 %", "65 %"}


@pytest.fixture(scope="module")
def gait():
    return make_gait(n_subjects=3, n_sequences=2, duration=2, random_state=0)


@pytest.fixture(scope="module", autouse=True)
def few_draws():
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"N_DRAWS": 2, "N_PAIRS": 4, "N_SEQUENCES": 2}.items():
            patch.setattr(reproduce, name, value)
        yield


@dataclass
class Run:
    """The findings of one call of the command, its output and the files that it wrote."""

    findings: reproduce.Findings
    printed: str
    folder: Path


@pytest.fixture(scope="module")
def run(gait, few_draws, tmp_path_factory):
    findings, study, printed = [], reproduce.reproduce, StringIO()

    def recorded(*arguments, **options):
        findings.append(study(*arguments, **options))
        return findings[0]

    folder = tmp_path_factory.mktemp("reproduce") / "out"
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(printed):
        patch.setattr("skpose._cli.commands.make_gait", lambda random_state: {3: gait}[random_state])
        patch.setattr(reproduce, "reproduce", recorded)
        assert main(["reproduce", "--out", str(folder), "--seed", "3", "--jobs", "1"]) == 0
    return Run(findings[0], printed.getvalue(), folder)


@pytest.fixture(scope="module")
def findings(run):
    return run.findings


def row(findings, quantity):
    (found,) = (row for row in findings.rows if row.quantity == quantity)
    return found


def test_every_number_of_section_3_is_in_the_table(findings):
    assert {row.paper for row in findings.rows} >= PAPER
    assert {row.section[:3] for row in findings.rows} == {"3.1", "3.2", "3.3", "3.4"}
    for row in findings.rows:
        assert row.first
        assert row.n_sequences > 0
        assert row.n_poses > 0
    assert all(note.endswith(".") and "\n" not in note for note in reproduce.DIFFERENCES)


def test_equal_seeds_give_equal_rows(gait, findings):
    assert reproduce.reproduce(gait, seed=3, n_jobs=2).rows == findings.rows
    assert reproduce.reproduce(gait, seed=4).rows != findings.rows


def test_ratios_are_those_of_the_geodesics(findings):
    skeleton, a, b = findings.pair
    line = pose_distances([a], [b], skeleton=skeleton)[0, 0]
    np.testing.assert_allclose(findings.ratios.min(), min(geodesic(a, b, skeleton).length / line, 1))
    assert row(findings, "r, lowest of 100 pairs").first == f"{findings.ratios.min():.3f}"


def test_the_p_value_of_figure_4_c_is_that_of_scipy(findings):
    test = mannwhitneyu(findings.shares["spatial"], findings.shares["angle"], alternative="greater")
    assert row(findings, "share with spatial is greater than with angle, p").first == f"{test.pvalue:.1e}"
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


def test_with_one_person_the_comparisons_of_people_are_left_out(gait):
    alone = gait[gait.subjects == gait.subjects[0]]
    findings = reproduce.reproduce(alone)
    assert any("Only one person" in note for note in findings.notes)
    assert not any("fig. 4 (a, b)" in row.section or "person" in row.quantity for row in findings.rows)
    assert "Only one person moves" in report.text(findings)


def test_without_runs_an_error_says_what_is_missing(gait):
    with pytest.raises(ValueError, match="none has an action that begins with 'run'"):
        reproduce.reproduce(gait[gait.actions == "walk"])


def test_the_command_writes_the_table_and_the_figures(run):
    document = (run.folder / "report.md").read_text(encoding="utf-8")
    for value in PAPER:
        assert value in run.printed
        assert f"| {value} |" in document
    table = [line for line in document.splitlines() if line.startswith("|")]
    assert len({line.count("|") for line in table}) == 1
    for name in re.findall(r"\]\((.*\.png)\)", document):
        picture = imread(run.folder / name)
        assert min(picture.shape[:2]) > 300
        assert np.ptp(picture[..., :3]) == 1  # black and white at least
    assert sorted(path.name for path in run.folder.iterdir()) == sorted(REPORT)
    text = (run.folder / "table.txt").read_text(encoding="utf-8")
    assert text.split() == run.printed.split("Written to")[0].split()


def test_without_matplotlib_the_command_stops_with_an_error(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("skpose._cli.commands.find_spec", lambda name: None)
    assert main(["reproduce", "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err == "skpose: the figures need matplotlib: pip install 'skpose[plot]'\n"
    assert not (tmp_path / "out").exists()


def test_on_cmu_files_figure_4_c_agrees_with_the_paper(cmu):
    findings = reproduce.Findings()
    reproduce._components(findings, cmu, walks_and_runs(cmu), None, None)
    modes = [float(row.first.rstrip("%")) for row in findings.rows[:2]]
    np.testing.assert_allclose(modes, [40, 80], atol=5)
    assert float(findings.rows[2].first) < 1e-6
