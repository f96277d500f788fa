"""A stream, frame by frame: equal to the search in recordings, and to the definition of what is going on."""

import copy
import pickle
import tracemalloc

import numpy as np
import pandas as pd
import pytest
import reference
from every_metric import EVERY_METRIC
from sklearn.exceptions import ConvergenceWarning

from skpose import Motion, Skeleton, motion_distances, pose_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.metrics import Velocity
from skpose.motions import MotionStream, StreamMatch, find_motion

ARM = Skeleton.chain(3)
LARGE_LIMITS = pytest.mark.filterwarnings("ignore:.* templates move no more than:UserWarning")


def wander(n_frames, rng, step=0.2):
    return np.cumsum(rng.normal(size=(n_frames, 3)) * step, axis=0) + rng.normal(size=3) * 0.5


@pytest.fixture(scope="module")
def recording():
    """Three movements, again and again and never the same, with something else between them; and these movements."""
    rng = np.random.default_rng(0)
    movements = [wander(n, rng) for n in (12, 20, 9)]
    parts = []
    for _ in range(12):
        parts += [wander(int(rng.integers(1, 15)), rng), movements[rng.integers(3)] * rng.uniform(0.9, 1.1)]
        parts[-1] = parts[-1][np.sort(rng.integers(0, len(parts[-1]), size=int(rng.integers(8, 25))))]
    return np.concatenate(parts), movements


def found_by(stream, frames, sizes=(1,)):
    """Return the matches of a whole stream, pushed in parts of these sizes, one after another."""
    matches, at, k = [], 0, 0
    while at < len(frames):
        matches += stream.push(frames[at : at + sizes[k % len(sizes)]]).matches
        at, k = at + sizes[k % len(sizes)], k + 1
    return matches + stream.finish()


def of_template(matches, template):
    """Return the matches of a template by distance, as `find_motion` has them."""
    found = [(m.start, m.stop, m.distance) for m in matches if m.template == template]
    return sorted(found, key=lambda m: (m[2], m[1]))


def offline(template, frames, limit, **given):
    found = find_motion(template, [frames], k=len(frames), **given)
    return [(m.start, m.stop, m.distance) for m in found if m.distance <= limit]


def assert_same(found, expected, exact):
    assert [m[:2] for m in found] == [m[:2] for m in expected]
    np.testing.assert_allclose([m[2] for m in found], [m[2] for m in expected], rtol=0 if exact else 1e-12)


@LARGE_LIMITS
@pytest.mark.parametrize("entry", EVERY_METRIC, ids=lambda entry: repr(entry.metric))
def test_matches_are_those_of_the_search(entry, recording):
    frames, movements = recording
    if entry.metric.iterative:
        frames, movements = frames[:40], [movement[:4] for movement in movements]
    given = {"skeleton": ARM, "metric": entry.metric}
    distances = [find_motion(movement, [frames], k=30, **given) for movement in movements]
    for share in (0.1, 0.5, 1.0):
        limit = float(np.quantile([m.distance for found in distances for m in found], share)) * (1.0 + 1e-9)
        stream = MotionStream(movements, max_distance=limit, **given)
        matches = found_by(stream, frames)
        assert {type(value) for match in matches for value in match} == {int, float}
        for template, movement in enumerate(movements):
            expected = offline(movement, frames, limit, **given)
            assert_same(of_template(matches, template), expected, exact=entry.metric.name != "spatial")
            if entry.distances is not None:
                by_definition = reference.stream_matches(entry.distances(movement, frames, ARM), limit)
                assert_same(of_template(matches, template), by_definition, exact=False)


def test_each_frame_has_the_sums_of_the_search(recording):
    """Distance and beginning of each window, and the least prefix."""
    frames, movements = recording
    for metric in ("angle", "rotation", "spatial"):
        stream = MotionStream(movements, skeleton=ARM, metric=metric, max_distance=0.3)
        paths = [reference.prefixes(pose_distances(m, frames, skeleton=ARM, metric=metric)) for m in movements]
        counted = [rows_that_count(m, 0.3 * np.arange(1, len(m) + 1), metric) for m in movements]
        assert [c.any() for c in counted] == [True] * 3
        last = [(0, 0)] * 3
        for t, frame in enumerate(frames):
            state = stream.push(frame)
            assert state.frame == t
            assert stream.n_frames == t + 1
            for match in state.matches:
                last[match.template] = max(last[match.template], (match.start, match.stop), key=lambda w: w[1])
            for i, (sums, starts) in enumerate(paths):
                n = len(sums)
                assert state.distances[i] == pytest.approx(sums[-1, t] / n, rel=1e-12)
                assert state.starts[i] == starts[-1, t]
                here = counted[i] & in_tempo(starts[:, t], t)
                rows = [r for r in range(n) if here[r] and not reference.overlap((starts[r, t], t + 1), last[i])]
                ratio = min((sums[r, t] / (0.3 * (r + 1)) for r in rows), default=np.inf)
                assert state.ratios[i] == pytest.approx(ratio, rel=1e-12)
                if ratio > 1.0:
                    assert state.progress[i] == 0.0
                else:
                    row = round(state.progress[i] * n) - 1
                    assert sums[row, t] / (0.3 * (row + 1)) == pytest.approx(ratio, rel=1e-12)
                    assert row in rows


def rows_that_count(template, limits, metric):
    """Prefixes for which no pose of the template passes, however long it is held."""
    D = pose_distances(template, skeleton=ARM, metric=metric)
    return np.array([min(D[: i + 1, q].sum() for q in range(len(D))) > limits[i] for i in range(len(D))])


@pytest.mark.parametrize("sizes", [(1,), (7,), (1, 30, 2, 5), (1000,)])
def test_chunks_change_nothing(recording, sizes):
    frames, movements = recording
    expected = found_by(MotionStream(movements, skeleton=ARM, max_distance=0.8), frames)
    assert len(expected) > 10
    stream = MotionStream(movements, skeleton=ARM, max_distance=0.8)
    assert found_by(stream, frames, sizes) == expected
    assert found_by(stream, frames, sizes) == expected, "a second stream is another one than the first"
    whole, single = (MotionStream(movements, skeleton=ARM, max_distance=0.8) for _ in range(2))
    for at in range(0, len(frames), 11):
        together, alone = whole.push(frames[at : at + 11]), [single.push(frame) for frame in frames[at : at + 11]]
        assert together.matches == [match for state in alone for match in state.matches]
        for name in set(together._fields) - {"matches"}:
            np.testing.assert_array_equal(getattr(together, name), getattr(alone[-1], name))


@LARGE_LIMITS
@pytest.mark.parametrize("limit", [0.3, 0.8, 2.0])
def test_what_is_returned_is_final(recording, limit):
    """At each frame: the matches so far, and those that are open, are those of the search in the frames so far."""
    frames, movements = recording
    stream, matches, n_open = MotionStream(movements, skeleton=ARM, metric="position", max_distance=limit), [], []
    for t in range(len(frames)):
        matches += stream.push(frames[t]).matches
        n_open.append(len(copy.deepcopy(stream).finish()))
        if t % 7 == 0 or t > len(frames) - 5:
            so_far = matches + copy.deepcopy(stream).finish()
            for i, movement in enumerate(movements):
                expected = offline(movement, frames[: t + 1], limit, skeleton=ARM, metric="position")
                assert_same(of_template(so_far, i), expected, exact=True)
    if limit < 1.0:
        assert max(n_open) <= 9, "little is known before the end"
        assert n_open.count(0) > len(n_open) / 10


@LARGE_LIMITS
@pytest.mark.parametrize("room", [1, 64])
def test_random_costs(room, monkeypatch):
    """Many windows that overlap, with equal sums: poses on a line, at whole numbers; also where room must be made."""
    monkeypatch.setattr("skpose.motions._stream_rows.FIRST_ROOM", room)
    rng = np.random.default_rng(1)
    for _ in range(25):
        frames = rng.integers(0, 4, size=(80, 1)).astype(float)
        templates = [rng.integers(0, 4, size=(int(n), 1)).astype(float) for n in rng.integers(1, 9, size=3)]
        limit = float(rng.choice([0.05, 0.3, 0.6, 3.0]))
        stream = MotionStream(templates, metric="angle", max_distance=limit)
        matches = found_by(stream, frames, (1, 3))
        for i, template in enumerate(templates):
            expected = reference.stream_matches(np.abs(template - frames.T), limit)
            assert_same(of_template(matches, i), expected, exact=True)


def arm_at(times):
    """Two movements of an arm: a wave with one joint, and a lift with another."""
    wave = np.stack([np.sin(2 * np.pi * times), 0 * times, 0 * times], axis=1)
    lift = np.stack([0 * times, 1.2 * np.sin(np.pi * times), 0.4 * np.sin(np.pi * times)], axis=1)
    return wave, lift


@pytest.fixture(scope="module")
def labelled():
    rng = np.random.default_rng(2)
    templates, labels = [], []
    for n_frames in (30, 24, 36, 28):
        for label, movement in zip(("wave", "lift"), arm_at(np.linspace(0, 1, n_frames)), strict=True):
            templates.append(movement * rng.uniform(0.85, 1.15) + rng.normal(size=3) * 0.02)
            labels.append(label)
    return templates, labels


def least_distances(template, motion):
    """Return, for each prefix of a template, the least distance of its paths in a motion."""
    sums = reference.prefixes(pose_distances(template, motion, skeleton=ARM))[0].min(axis=1)
    return sums / np.arange(1, len(template) + 1)


@pytest.mark.parametrize("grouped", [False, True])
def test_limits_are_learnt_from_the_other_templates_of_the_label(grouped, labelled):
    """Each template is left out: how near are the others, of other groups, at each share of the movement?"""
    templates, labels = labelled
    groups = ["anna", "anna", "anna", "anna", "ben", "ben", "carl", "carl"] if grouped else range(8)
    stream = MotionStream(templates, labels=np.array(labels), groups=groups if grouped else None, skeleton=ARM)
    assert stream.labels == labels
    D = motion_distances(templates, templates, skeleton=ARM, alignment="subsequence")
    largest = {}
    for label in ("wave", "lift"):
        some = [i for i in range(8) if labels[i] == label]
        others = {i: [j for j in some if groups[j] != groups[i]] for i in some}
        expected = max(min(D[j, i] for j in others[i]) for i in some)
        found = [stream.max_distances[i] for i in some]
        np.testing.assert_allclose(found, expected, rtol=1e-12)
        prefixes = {(j, i): least_distances(templates[j], templates[i]) for i in some for j in others[i]}
        for share in np.arange(1, 101):
            rows = {j: -(-share * len(templates[j]) // 100) - 1 for j in some}
            largest[label, share] = max(min(prefixes[j, i][rows[j]] for j in others[i]) for i in some)
    frames = np.concatenate([templates[0] * 1.05, templates[1] * 0.97])
    paths = [reference.prefixes(pose_distances(a, frames, skeleton=ARM)) for a in templates]
    n_going_on = 0
    for t, frame in enumerate(frames):
        state = stream.push(frame)
        if stream._last.any():
            break
        for i, label in enumerate(labels):
            n = len(templates[i])
            limits = np.array([(r + 1) * largest[label, -(-100 * (r + 1) // n)] for r in range(n)])
            counted = rows_that_count(templates[i], limits, "spatial") & in_tempo(paths[i][1][:, t], t)
            ratio = np.min(paths[i][0][counted, t] / limits[counted], initial=np.inf)
            assert state.ratios[i] == pytest.approx(ratio, rel=1e-9)
            n_going_on += ratio <= 1.0
    assert n_going_on > 20


def in_tempo(starts, t):
    """Paths of prefixes that are no more than twice as long, and no less than half."""
    n, length = np.arange(1, len(starts) + 1), t + 1 - starts
    return (length <= 2 * n) & (n <= 2 * length)


def test_what_is_going_on(labelled):
    """The movement, how far it is, and nothing else: not while somebody stands, nor in other movements."""
    templates, labels = labelled
    stream = MotionStream(templates, labels=labels, skeleton=ARM)
    rng = np.random.default_rng(3)
    still = np.zeros((40, 3))

    def states(frames):
        return [stream.push(frame) for frame in frames + rng.normal(size=frames.shape) * 0.003]

    for movement, label in zip(arm_at(np.linspace(0, 1, 32)), ("wave", "lift"), strict=True):
        before, during = states(still), states(movement)
        assert {state.label for state in before[5:]} == {None}
        middle = during[12:26]
        assert [state.label for state in middle] == [label] * 14
        assert min(state.sureness for state in middle) > 0.3
        for t, state in enumerate(middle, start=12):
            assert labels[state.template] == label
            assert state.progress[state.template] == pytest.approx((t + 1) / 32, abs=0.2)
            rival = min(r for r, other in zip(state.ratios, labels, strict=True) if other != label)
            assert state.sureness == pytest.approx(1 - state.ratios.min() / min(1, rival))
        after = states(still)
        assert {state.label for state in after[8:]} == {None}, "somebody who stands has ended the movement"
        assert {m.label for state in during + after for m in state.matches} == {label}
    others = {
        "the lift, in the other direction": -arm_at(np.linspace(0, 1, 32))[1],
        "both movements at once": sum(arm_at(np.linspace(0, 1, 32))),
        "noise": rng.normal(size=(80, 3)),
        "at rest elsewhere": np.tile([0.6, 0.6, 0.2], (60, 1)),
    }
    for name, frames in others.items():
        stream.finish()
        found = states(frames)
        assert {state.label for state in found} == {None}, name
        assert max(state.sureness for state in found) < 0.1, name
        assert not any(state.matches for state in found), name


def test_two_labels_that_fit_as_well_are_not_sure(labelled):
    templates, _ = labelled
    wave = templates[0]
    stream = MotionStream([wave, wave + 1e-9], labels=["a", "b"], skeleton=ARM, max_distance=0.2)
    assert stream.push(0.95 * wave[:20]).sureness < 1e-6
    assert MotionStream([wave, wave], skeleton=ARM, max_distance=0.2).push(wave[:20]).sureness == 0.0
    two = MotionStream([wave, 1.1 * wave], skeleton=ARM, max_distance=0.5, min_sureness=0.6)
    labels = [(state.sureness, state.label) for state in map(two.push, 1.03 * wave)]
    assert {label is None for sureness, label in labels if sureness >= 0.6} == {False}
    assert {label for sureness, label in labels if sureness < 0.6} == {None}
    assert max(labels)[0] > 0.6
    alone = MotionStream([wave], skeleton=ARM, max_distance=0.2).push(wave[:20])
    assert (alone.label, alone.template, alone.sureness) == (0, 0, 1.0)


def test_who_stops_in_the_middle_is_in_the_middle(labelled):
    """For as long as it took to come there, and not for ever."""
    templates, labels = labelled
    stream = MotionStream(templates, labels=labels, skeleton=ARM)
    half = templates[1][:14]
    stream.push(half)
    state = stream.push(np.repeat(half[-1:], 10, axis=0))
    assert state.label == "lift"
    assert state.progress[1] == pytest.approx(0.5, abs=0.15)
    assert stream.push(np.repeat(half[-1:], 60, axis=0)).label is None


def test_memory_does_not_grow(labelled):
    templates, labels = labelled
    stream = MotionStream(templates, labels=labels, skeleton=ARM, metric="position")
    rng = np.random.default_rng(4)
    parts = [*templates, *(wander(30, rng) * 0.5 for _ in templates), np.zeros((30, 3))]
    n_matches, kept, sizes = 0, [], []
    tracemalloc.start()
    try:
        for _ in range(4):
            for part in rng.permutation(len(parts)):
                frames = parts[part] * rng.uniform(0.9, 1.1) + rng.normal(size=parts[part].shape) * 0.01
                for frame in frames:
                    n_matches += len(stream.push(frame).matches)
                    kept.append(max(windows.n_pending for windows in stream._windows))
            sizes.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert n_matches > 25
    assert max(kept) < 100
    assert sizes[-1] < sizes[1] + 30_000
    fresh = MotionStream(templates, labels=labels, skeleton=ARM, metric="position")
    assert len(pickle.dumps(stream)) < len(pickle.dumps(fresh)) + 20_000


def test_a_stream_that_is_stuck_keeps_a_window_a_frame_and_is_right(labelled):
    """The only case in which memory grows, up to the frame in which something moves."""
    template = labelled[0][0]
    stuck = np.concatenate([template, np.repeat(template[-1:], 400, axis=0), template + 0.01, np.ones((9, 3))])
    stream = MotionStream([template], skeleton=ARM, metric="position", max_distance=0.05)
    matches = found_by(stream, stuck)
    assert_same(of_template(matches, 0), offline(template, stuck, 0.05, skeleton=ARM, metric="position"), exact=True)


def test_motions_datasets_and_tables():
    gait = make_gait(n_subjects=3, n_sequences=1, duration=2, frame_rate=20, random_state=0)
    stream = MotionStream(gait[:4], labels=gait.actions[:4], min_sureness=0.0)
    assert (len(stream), stream.frame_rate, stream.skeleton) == (4, 20, gait[:4].skeleton)
    assert repr(stream) == "MotionStream(4 templates, 2 labels, 160 frames at 20 Hz, metric='spatial', 0 pushed)"
    motion = gait[4]
    state = stream.push(motion[:30])
    assert state.label == gait.actions[4]
    with pytest.raises(ValueError, match=r"pose has 10 Hz and the templates have 20 Hz.*pose.resample\(20\)"):
        stream.push(motion.resample(10))
    assert stream.n_frames == 30
    arrays = MotionStream([m.angles for m in gait[:4]], labels=gait.actions[:4], skeleton=gait[:4].skeleton)
    assert arrays.frame_rate is None
    first = arrays.push(motion.angles[:1])
    for pose in (motion.angles[0], motion.angles[0].tolist(), pd.Series(motion.angles[0], motion.skeleton.dof_names)):
        arrays.finish()
        np.testing.assert_array_equal(arrays.push(pose).distances, first.distances)
    arrays.finish()
    arrays.push(pd.DataFrame(motion.angles[:30], columns=motion.skeleton.dof_names))
    assert arrays.n_frames == 30


def test_float32_poses_are_compared_in_float64(labelled):
    templates, labels = labelled
    single = [template.astype(np.float32) for template in templates]
    given = {"labels": labels, "skeleton": ARM}
    first, second = MotionStream(single, **given), MotionStream([t.astype(np.float64) for t in single], **given)
    for pose in single[0]:
        np.testing.assert_array_equal(first.push(pose).distances, second.push(pose.astype(np.float64)).distances)


MOVING = [np.linspace([0, 0, 0], [1, scale, 0], 9) for scale in (1.0, 1.1, 1.2)]


@pytest.mark.parametrize(
    ("given", "error", "match"),
    [
        ({"templates": MOVING[0]}, ValueError, r"templates must be motions.*pass \[templates\]"),
        ({"templates": []}, ValueError, "templates must be motions"),
        ({"templates": [MOVING[0], MOVING[1][:, :2]]}, ValueError, r"templates\[1\].* has 2 columns"),
        ({"templates": [MOVING[0], np.full((3, 3), np.nan)]}, ValueError, r"templates\[1\] contains NaN"),
        (
            {"templates": [Motion(ARM, MOVING[0], 30), Motion(ARM, MOVING[1], 60)]},
            ValueError,
            "one frame rate.*resample",
        ),
        ({"templates": [Motion(ARM, MOVING[0], 30), MOVING[1]]}, TypeError, "all skpose.Motion or all arrays"),
        ({"max_distance": None}, ValueError, r"the label 0 has one template, so that.*labels=.*max_distance="),
        ({"max_distance": None, "labels": "aab"}, TypeError, "labels must be a sequence"),
        ({"max_distance": None, "labels": ["a", "a", "b"]}, ValueError, "the label 'b' has one template"),
        ({"labels": ["a"]}, ValueError, "labels has length 1, for 3 templates"),
        ({"groups": [1, 2]}, ValueError, "groups has length 2, for 3 templates"),
        (
            {"max_distance": None, "labels": ["a"] * 3, "groups": ["p"] * 3},
            ValueError,
            "'a' has templates of one group, 'p', alone",
        ),
        ({"min_sureness": 1.0}, ValueError, "'min_sureness' parameter"),
        ({"labels": ["a", None, "b"]}, TypeError, r"labels\[1\] is None"),
        ({"labels": ["a", np.nan, "b"]}, TypeError, r"labels\[1\] is nan"),
        ({"labels": ["a", ["b"], "b"]}, TypeError, r"labels\[1\] is \['b'\]"),
        ({"max_distance": 0.0}, ValueError, "'max_distance' parameter"),
        ({"max_distance": np.nan}, ValueError, "'max_distance' parameter"),
        ({"metric": "velocity"}, ValueError, "frames after it are not known yet"),
        ({"metric": Velocity(0.1)}, ValueError, "frames after it are not known yet"),
        ({"metric": "centered"}, ValueError, "frames after it are not known yet"),
        ({"metric": "euclidean"}, ValueError, "'metric' parameter"),
        ({"skeleton": None, "metric": "spatial"}, ValueError, "needs a skeleton"),
    ],
)
def test_refused_templates(given, error, match):
    with pytest.raises(error, match=match):
        MotionStream(**{"templates": MOVING, "skeleton": ARM, "max_distance": 0.1} | given)


@pytest.mark.parametrize(
    ("pose", "error", "match"),
    [
        (np.zeros(2), ValueError, "pose.* 2 "),
        (np.zeros((4, 5)), ValueError, "pose has 5 columns"),
        (np.zeros((1, 1, 3)), ValueError, "dim 3|must have shape"),
        (np.zeros((0, 3)), ValueError, "0 sample"),
        ([0.0, np.nan, 0.0], ValueError, "in 1 of 1 frames, first in frame 5 of the stream: leave a lost frame out"),
        (np.array([[0.0] * 3, [np.inf, 0, 0], [np.nan] * 3]), ValueError, "in 2 of 3 frames, first in frame 6"),
        (Motion(Skeleton.chain(2), np.zeros((3, 2)), 30), ValueError, "pose"),
        ([Motion(ARM, MOVING[0], 30)], TypeError, "pose must be .* list of Motions"),
        (ARM, TypeError, "got a Skeleton"),
        ("standing", ValueError, "pose|string|array"),
    ],
)
@pytest.mark.parametrize("skeleton", [ARM, None])
def test_refused_poses_change_nothing(pose, error, match, skeleton):
    given = {"skeleton": skeleton, "metric": "angle", "max_distance": 0.1}
    stream, other = MotionStream(MOVING, **given), MotionStream(MOVING, **given)
    stream.push(MOVING[0][:5])
    with pytest.raises(error, match=match):
        stream.push(pose)
    found, expected = (stream.push(MOVING[0][5:]).matches, other.push(MOVING[0]).matches)
    assert found == expected
    assert found[0] == StreamMatch(0, 0, 0, 9, 0.0), "known at once, as nothing is better than zero"
    assert stream.finish() == other.finish()


def test_copies_of_a_template_show_nothing():
    with pytest.raises(ValueError, match="the templates of the label 'a' are equal"):
        MotionStream([MOVING[0], MOVING[0].copy()], labels=["a", "a"], skeleton=ARM)


def test_templates_that_do_not_move_are_named(labelled):
    templates, labels = labelled
    still = [np.zeros((9, 3)) + offset for offset in (0.0, 0.1)]
    with pytest.warns(UserWarning, match=r"2 of 10 templates move no more.*templates\[8\], templates\[9\]\. They may"):
        stream = MotionStream([*templates, *still], labels=[*labels, "still", "still"], skeleton=ARM)
    state = stream.push(np.full((20, 3), 0.05))
    assert state.label is None
    assert np.isinf(state.ratios[8:]).all()
    assert {match.label for match in stream.finish()} == {"still"}


def test_degrees_and_missing_skeletons_are_warned_of():
    with pytest.warns(UserWarning, match="values of templates reach"):
        MotionStream([np.degrees(movement) for movement in MOVING], skeleton=ARM, max_distance=0.1)
    with pytest.warns(UserWarning, match='metric="auto" without a skeleton means "angle"'):
        stream = MotionStream(MOVING, max_distance=0.1)
    assert stream.metric.name == "angle"
    stream = MotionStream(MOVING, skeleton=ARM, max_distance=0.1)
    with pytest.warns(UserWarning, match="values of pose reach"):
        stream.push(np.full(3, 180.0))


def test_geodesics_that_do_not_converge_are_counted_in_each_call(monkeypatch):
    stream = MotionStream(MOVING, skeleton=ARM, max_distance=0.1)

    def advance(code, lanes, starts, frame, measure, tree, steps, column):
        column.sums.fill(1.0)
        return 2, 0.1

    monkeypatch.setattr("skpose.motions._stream_rows.advance_loop", lambda dtype: advance)
    for _ in range(2):
        with pytest.warns(ConvergenceWarning, match="4 of 54 geodesics did not converge"):
            stream.push(MOVING[0][:2])


def test_datasets_give_templates_on_their_mean_skeleton():
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1, frame_rate=12, random_state=0)
    assert isinstance(gait, MotionDataset)
    assert MotionStream(gait, labels=gait.actions).skeleton == gait.skeleton
