"""`skpose reproduce`: its numbers by hand, its table and its figures."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.image import imread

from skpose import geodesic, pose_distances
from skpose._cli.main import main
from skpose._cli.reproduce import FIGURES
from skpose._cli.studies import reproduce
from skpose.datasets import make_gait, walks_and_runs

pytestmark = pytest.mark.slow
PAPER = {"0.94", "40 %", "80 %", "< 1e-6", "90 %", "100 %", "60 %", "65 %"}


@pytest.fixture(scope="module")
def gait():
    return make_gait(n_subjects=3, n_sequences=2, duration=2, rotations="file", random_state=0)


@pytest.fixture(scope="module")
def run(gait, tmp_path_factory):
    """The findings of a call of the command, and the folder that it wrote."""
    findings, study = [], reproduce.reproduce
    folder = tmp_path_factory.mktemp("reproduce") / "out"
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"N_DRAWS": 2, "N_PAIRS": 4, "N_SEQUENCES": 2}.items():
            patch.setattr(reproduce, name, value)
        patch.setattr("skpose.datasets.make_gait", lambda rotations, random_state: {3: gait}[random_state])
        patch.setattr(reproduce, "reproduce", lambda *args, **kw: findings.append(study(*args, **kw)) or findings[0])
        assert main(["reproduce", "--out", str(folder), "--seed", "3", "--jobs", "1"]) == 0
        yield SimpleNamespace(findings=findings[0], folder=folder)


def value_of(run, quantity):
    (found,) = (row.first for row in run.findings.rows if row.quantity == quantity)
    return found


def test_ratios_are_those_of_the_geodesics(run):
    skeleton, a, b = run.findings.pair
    line = pose_distances([a], [b], skeleton=skeleton)[0, 0]
    lowest = run.findings.ratios.min()
    np.testing.assert_allclose(lowest, min(geodesic(a, b, skeleton).length / line, 1))
    assert value_of(run, "r, lowest of 100 pairs") == f"{lowest:.3f}"


def test_classification_by_hand(gait, run):
    """The nearest pose among the other sequences of the draw."""
    chosen = np.concatenate(list(run.findings.draws[0].values()))
    gait = walks_and_runs(gait)
    X, sequence = gait.poses(12)
    correct = []
    for left_out in chosen:
        rest = np.isin(sequence, chosen) & (sequence != left_out)
        D = pose_distances(X[sequence == left_out], X[rest], skeleton=gait.skeleton, metric="spatial")
        correct += list(gait.actions[sequence[rest][D.argmin(axis=1)]] == gait.actions[left_out])
    assert value_of(run, "poses classified right, leave one sequence out, spatial") == f"{np.mean(correct):.1%}"


def test_equal_seeds_give_equal_rows(gait, run):
    assert reproduce.STUDIES
    again = reproduce.Findings(draws=run.findings.draws)
    reproduce._ratios(again, gait, walks_and_runs(gait), np.random.default_rng([3, 0]), 2)
    assert again.rows == run.findings.rows[:2]


def test_the_table_and_the_figures(run, capsys):
    table = reproduce.table(run.findings)
    assert all(value in table for value in PAPER)
    assert {row.section[:3] for row in run.findings.rows} == {"3.1", "3.2", "3.3", "3.4"}
    assert sorted(path.name for path in run.folder.iterdir()) == sorted(FIGURES)
    for name in FIGURES:
        picture = imread(run.folder / name)
        assert min(picture.shape[:2]) > 300
        assert np.ptp(picture[..., :3]) == 1  # black and white at least
    assert main(["reproduce", "--out", str(run.folder), "--seed", "3"]) == 1  # nothing is overwritten
    assert "already exists" in capsys.readouterr().err


def test_figure_4_c_on_cmu_files_agrees_with_the_paper(cmu):
    findings = reproduce.Findings()
    reproduce._components(findings, cmu, walks_and_runs(cmu), None, None)
    modes = [float(row.first.rstrip("%")) for row in findings.rows[:2]]
    np.testing.assert_allclose(modes, [40, 80], atol=5)
    assert float(findings.rows[2].first) < 1e-6
