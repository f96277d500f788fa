"""Long work shows its progress where that is requested, and nowhere else."""

import sys

import numpy as np
import pytest
from conftest import HAS_CALLBACKS, Recorder, random_tree
from sklearn.base import clone

from skpose import (
    MedoidShift,
    PoseDistanceTransformer,
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    SpatialMDS,
    pose_distances,
    pose_distances_chunked,
)
from skpose._parallel import progress as progress_module
from skpose._parallel.progress import progress

TREE = random_tree(0)


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).normal(0, 0.3, size=(60, TREE.n_dofs))


def test_without_a_terminal_there_are_plain_lines(capsys, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress_module.time, "monotonic", lambda: now[0])
    with progress("work", 100, verbose=1) as advance:
        for _ in range(100):
            now[0] += 4.0
            advance()
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "work: 3%, 6 min 28 s to go"
    assert len(lines) == 33 + 1
    assert lines[-1] == "work: done in 6 min 40 s"


def test_without_rich_there_are_plain_lines(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "rich.console", None)
    with progress("work", 2, verbose=1) as advance:
        advance()
    assert capsys.readouterr().err.startswith("work: done in ")


def test_on_a_terminal_there_is_a_bar(capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm-256color")
    with progress("work", 2, verbose=1) as advance:
        advance()
        advance()
    err = capsys.readouterr().err
    assert "work" in err
    assert "100%" in err
    assert "\x1b[" in err


@pytest.mark.parametrize("verbose", [0, 1])
def test_every_call_that_may_take_long_shows_its_progress_if_requested(X, capsys, verbose):
    estimators = [
        PoseDistanceTransformer(TREE),
        PoseKNeighborsTransformer(TREE),
        PoseRadiusNeighborsTransformer(TREE),
        SpatialMDS(skeleton=TREE),
        MedoidShift(TREE, bandwidth=1.0),
    ]
    for estimator in estimators:
        estimator = clone(estimator).set_params(verbose=verbose)
        (estimator.fit_transform if hasattr(estimator, "fit_transform") else estimator.fit_predict)(X)
        captured = capsys.readouterr()
        assert captured.out == ""
        assert ("60" in captured.err) == bool(verbose)
    pose_distances(X, metric="angle", verbose=verbose)
    assert (capsys.readouterr().err != "") == bool(verbose)
    list(pose_distances_chunked(X, metric="angle", verbose=verbose))
    assert (capsys.readouterr().err != "") == bool(verbose)


def test_each_stage_of_an_estimator_is_one_bar(X, capsys, monkeypatch):
    monkeypatch.setattr("skpose.manifold._classical_mds.BATCH", 100)
    SpatialMDS(skeleton=TREE, landmarks=20, random_state=0, verbose=1).fit(X).transform(X)
    lines = [line.split(":")[0] for line in capsys.readouterr().err.splitlines()]
    assert lines == ["20 × 20 distances", *["60 poses in 2 dimensions"] * 2]
    monkeypatch.setattr("skpose.cluster._shift.WEIGHTS", 600)
    shift = MedoidShift(TREE, bandwidth=1.0, verbose=1).fit(X)
    lines = [line.split(":")[0] for line in capsys.readouterr().err.splitlines()]
    assert lines[:2] == ["60 × 60 distances", "shift of 60 samples"]
    assert len(lines) <= 1 + shift.n_iter_


@pytest.mark.skipif(not HAS_CALLBACKS, reason="scikit-learn has no callbacks before 1.9")
def test_callbacks_see_the_tiles_of_distances(X, monkeypatch):
    monkeypatch.setattr("skpose.metrics._matrix.ENCODED_AT_ONCE", 16)
    recorder = Recorder()
    SpatialMDS(TREE, n_components=2).set_callbacks(recorder).fit(X)
    assert recorder.tasks == ["fit", "distances", "60 × 60 distances", *["step"] * 10, "eigenvectors"]
    assert recorder.open == 0


@pytest.mark.skipif(not HAS_CALLBACKS, reason="scikit-learn has no callbacks before 1.9")
def test_scikit_learns_own_bar_shows_them(X, monkeypatch, capsys):
    from sklearn.callback import ProgressBar

    monkeypatch.setattr("skpose.metrics._matrix.ENCODED_AT_ONCE", 16)
    mds = SpatialMDS(TREE, n_components=2).set_callbacks(ProgressBar()).fit(X)
    np.testing.assert_array_equal(mds.embedding_, SpatialMDS(TREE, n_components=2).fit(X).embedding_)
    assert "60 × 60 distances" in capsys.readouterr().out
