"""`skpose compare`: the accuracies in its table, its folders."""

import warnings
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from skpose import motion_distances, pose_distances
from skpose._cli.main import main
from skpose._cli.studies import compare as study
from skpose._cli.studies.compare import COMPARED, choose_actions, compare, prepare, warp_all
from skpose.datasets import MotionDataset, make_actions, make_gait
from skpose.io import save_bvh
from skpose.manifold import SpatialMDS


@pytest.fixture(scope="module")
def actions():
    return make_actions(2, 2, actions=["jump", "squat", "wave"], frame_rate=24, random_state=0)


@pytest.fixture(scope="module")
def run(actions):
    """The results of the command, and what it prints."""
    results, printed = [], StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(printed):
        patch.setattr("skpose.datasets.make_actions", lambda rotations, random_state: actions)
        patch.setattr(study, "compare", lambda *args, **kw: results.extend(compare(*args, **kw)) or results)
        assert main(["compare", "--jobs", "1"]) == 0
    return SimpleNamespace(results=results, printed=printed.getvalue())


def table(out):
    """The cells of each metric, without the time."""
    rows = [line.split() for line in out.splitlines()]
    return {row[0]: row[1:6] for row in rows if row and row[0] in COMPARED}


def test_accuracies_are_those_of_the_nearest_neighbour_in_other_groups(actions, run):
    dataset = prepare(actions)
    assert {motion.frame_rate for motion in dataset} == {12.0}
    assert any(bone.is_ball for bone in dataset.skeleton.bones)
    X, sequence = dataset.poses()
    assert list(table(run.printed)) == list(COMPARED)
    assert "12 motions of 3 actions by 2 people" in run.printed
    for result in run.results[:2]:
        assert table(run.printed)[result.metric] == [f"{share:.1%}" for share in result[1:6]]
        D = pose_distances(X, skeleton=dataset.skeleton, metric=result.metric)
        M = motion_distances(dataset, skeleton=dataset.skeleton, metric=result.metric)
        np.testing.assert_allclose(warp_all(D, [np.flatnonzero(sequence == i) for i in range(12)]), M, rtol=1e-12)
        for accuracy, distances, labels, groups in (
            (result.frames_of_others, D, dataset.actions[sequence], dataset.subjects[sequence]),
            (result.motions_of_others, M, dataset.actions, dataset.subjects),
            (result.frames, D, dataset.actions[sequence], sequence),
            (result.motions, M, dataset.actions, np.arange(12)),
        ):
            in_other_groups = np.where(groups[:, None] == groups, np.inf, distances)
            assert accuracy == np.mean(labels[in_other_groups.argmin(axis=1)] == labels)
        mds = SpatialMDS(dataset.skeleton, n_components=1, metric=result.metric)
        shares = [mds.fit(X[sequence == i]).explained_variance_ratio_[0] for i in range(12)]
        np.testing.assert_allclose(result.first_component, np.median(shares))


def test_actions_are_those_of_two_people(actions):
    words = np.array(actions.actions)
    words[:2], words[2] = "Jump", "leap"
    chosen = choose_actions(MotionDataset(actions.motions, actions.subjects, actions.trials, words))
    assert sorted(set(chosen.actions)) == ["jump", "squat", "wave"]  # case does not matter
    assert len(chosen) == len(actions) - 1
    alone = actions[actions.subjects == "01"]
    assert len(choose_actions(alone)) == len(alone)  # each is done twice
    with pytest.raises(ValueError, match="two actions"):
        choose_actions(actions[actions.actions == "jump"])


def save(dataset, folder, scale=1.0):
    """Write motions as BVH files named SUBJECT_ACTION_TRIAL.bvh."""
    folder.mkdir()
    for motion, *labels in zip(dataset, dataset.subjects, dataset.actions, dataset.trials, strict=True):
        save_bvh(folder / f"{'_'.join(labels)}.bvh", motion, scale=scale)


def test_a_folder_of_bvh_files(actions, capsys, tmp_path):
    chosen = actions[actions.actions != "wave"]
    save(chosen, tmp_path / "takes", scale=0.01)
    assert main(["compare", str(tmp_path / "takes"), "--scale", "0.01"]) == 0
    assert "8 motions of 2 actions by 2 people" in capsys.readouterr().out
    next(Path(tmp_path, "takes").iterdir()).rename(tmp_path / "takes" / "jump.bvh")
    assert main(["compare", str(tmp_path / "takes")]) == 1
    assert "SUBJECT_ACTION_TRIAL.bvh" in capsys.readouterr().err
    assert main(["compare", str(tmp_path / "nowhere")]) == 1


def test_one_person_and_the_papers_protocol(capsys, tmp_path):
    gait = make_gait(1, 2, duration=1.0, random_state=0)
    save(gait, tmp_path / "gait")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert main(["compare", str(tmp_path / "gait"), "--paper"]) == 0
    out = capsys.readouterr().out
    assert "4 motions of 2 actions by 1 people" in out
    assert "angles as they are" in out
    assert table(out)["angle"][:2] == ["-", "-"]  # there are no other people


@pytest.mark.slow
def test_the_papers_protocol_on_real_files(cmu_folder, capsys):
    assert main(["compare", str(cmu_folder), "--paper"]) == 0
    out = capsys.readouterr().out
    assert "40 motions of 2 actions by 5 people, 1,363 poses at 12 Hz" in out
    assert table(out)["angle"] == ["99.1%", "100.0%", "100.0%", "100.0%", "40.0%"]
    assert table(out)["spatial"] == ["100.0%", "100.0%", "100.0%", "100.0%", "81.8%"]
