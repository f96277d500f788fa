import re
from itertools import groupby

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_hex
from sklearn.metrics import confusion_matrix

from skpose import Skeleton, forward_kinematics, motion_distances, pose_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.kinematics import retarget
from skpose.plot import Confusion, ConfusionDisplay

pytestmark = pytest.mark.usefixtures("agg")

RNG = np.random.default_rng(0)
NAMES = ["walk", "run", "hop", "skip"]


@pytest.fixture(scope="module")
def gait():
    """Twelve short motions of three people, labelled as four actions."""
    walks = make_gait(3, 4, activities=["walk"], duration=0.6, frame_rate=15, random_state=0).to_rotvec()
    return MotionDataset(walks, subjects=walks.subjects, actions=NAMES * 3)


PREDICTED = ["walk", "hop", "hop", "run", "run", "hop", "hop", "skip", "run", "hop", "walk", "skip"]


@pytest.fixture
def display(gait, agg):
    found = ConfusionDisplay.from_predictions(gait.actions, PREDICTED, gait, metric="position")
    found.figure_.canvas.draw()
    return found


def texts_of(ax):
    return [text for text in ax.texts if text.get_visible() and text.get_text()]


def numbers_of(display):
    """The numbers that are seen in the cells, and zero elsewhere."""
    counts = np.zeros_like(display.confusion_matrix)
    for text in texts_of(display.matrix_ax_):
        column, row = text.get_position()
        counts[row, column] = int(text.get_text())
    return counts


def figures_of(ax):
    """The joints of the figures of a strip, in m from the root: (n_poses, n_joints, 2)."""
    per_side = [np.stack(line.get_data(), axis=1).reshape(-1, 3, 2)[:, 1] for line in ax.lines]
    transforms = [line.get_transform() for line in ax.lines]
    figures = [
        np.concatenate([per_side[i] for i in some])
        for _, some in groupby(range(len(transforms)), lambda i: id(transforms[i]))
    ]
    return [np.array(sorted(figure.tolist())) for figure in figures]


def labels_of(display, pair):
    """The text of the figure on the lines of one pair: the heading and the labels of both strips."""
    found = []
    for ax in display.figure_.axes:
        if ax is not display.matrix_ax_:
            found += [text.get_text() for text in texts_of(ax)]
    return found[4 * pair : 4 * pair + 4]


def test_numbers_are_those_of_scikit_learn(gait, display):
    np.testing.assert_array_equal(
        display.confusion_matrix, confusion_matrix(gait.actions, PREDICTED, labels=display.labels)
    )
    np.testing.assert_array_equal(numbers_of(display), display.confusion_matrix)
    ax = display.matrix_ax_
    for axis in (ax.xaxis, ax.yaxis):
        assert [label.get_text() for label in axis.get_ticklabels()] == display.labels
        assert axis.get_ticklocs().tolist() == [0, 1, 2, 3]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("predicted", "true")
    assert ax.get_ylim() == (3.5, -0.5)
    assert ax.get_title(loc="left") == "5 of 12 motions recognised, 41.7%"
    assert np.trace(display.confusion_matrix) == 5


def test_colours_are_shares_of_the_true_class(display):
    right, wrong = (image.get_array() for image in display.matrix_ax_.get_images())
    shares = display.confusion_matrix / display.confusion_matrix.sum(axis=1, keepdims=True)
    diagonal = np.eye(4, dtype=bool)
    np.testing.assert_array_equal(right.mask, ~diagonal | (shares == 0))
    np.testing.assert_array_equal(wrong.mask, diagonal | (shares == 0))
    np.testing.assert_allclose(right.filled(0) + wrong.filled(0), shares)


def test_confusions_are_all_in_order_of_frequency(gait, display):
    wrong = [i for i in range(12) if PREDICTED[i] != gait.actions[i]]
    assert sorted(one.sample for one in display.confusions) == wrong
    D = motion_distances(gait, metric="position")
    for one in display.confusions:
        assert (one.true, one.predicted) == (gait.actions[one.sample], PREDICTED[one.sample])
        same = [i for i in range(12) if (gait.actions[i], PREDICTED[i]) == (one.true, one.predicted)]
        assert one.frequency == len(same)
        others = [
            j for j in range(12) if gait.actions[j] == one.predicted and gait.subjects[j] != gait.subjects[one.sample]
        ]
        best = min(others, key=lambda j: D[one.sample, j])
        assert (one.nearest, one.distance) == (best, pytest.approx(D[one.sample, best], rel=1e-12))
    frequencies = [one.frequency for one in display.confusions]
    assert frequencies == sorted(frequencies, reverse=True)
    for _, pair in groupby(display.confusions, lambda one: (one.true, one.predicted)):
        some = [one.distance for one in pair]
        assert some == sorted(some)
    pairs = [key for key, _ in groupby(display.confusions, lambda one: (one.true, one.predicted))]
    assert len(pairs) == len(set(pairs))


def test_strips_are_the_confused_motion_and_the_nearest(gait, display):
    first = [next(pair) for _, pair in groupby(display.confusions, lambda one: (one.true, one.predicted))]
    assert display.shown_ == first[:3]
    assert len(display.strip_axes_) == 3
    for one, both in zip(display.shown_, display.strip_axes_, strict=True):
        for index, ax in zip((one.sample, one.nearest), both, strict=True):
            motion = retarget(gait[index], gait.skeleton, method="numbers")
            frames = np.unique(np.rint(np.linspace(0, len(motion) - 1, 7)).astype(int))
            joints = forward_kinematics(motion.angles[frames], gait.skeleton)
            drawn = figures_of(ax)
            assert len(drawn) == 7
            expected = [joints[:, :, plane] for plane in ([0, 1], [2, 1])]
            sorted_ones = [[np.array(sorted(pose.tolist())) for pose in some] for some in expected]
            assert any(np.allclose(drawn, some, atol=1e-12) for some in sorted_ones)


def test_labels_say_which_motions_they_are(gait, display):
    for k, one in enumerate(display.shown_):
        heading, view, upper, lower = labels_of(display, k)
        assert heading == f"{one.true} taken for {one.predicted}, {one.frequency} of 3"
        assert re.fullmatch("seen from (the left|the right|the front|behind)", view)
        for index, action, label in ((one.sample, one.true, upper), (one.nearest, one.predicted, lower)):
            duration = (len(gait[index]) - 1) / 15
            assert label == f"{action}\nmotion {index}, subject {gait.subjects[index]}\n{duration:.1f} s"


@pytest.mark.parametrize(("axis", "projection"), [("x", "zy"), ("z", "xy")])
def test_seen_from_the_side_that_shows_the_movement(gait, axis, projection):
    skeleton = gait[0].skeleton
    poses = np.zeros((2, 9, skeleton.n_dofs))
    poses[0, :, skeleton.dof_names.index(f"left_upper_arm_rotvec_{axis}")] = np.linspace(0, -1.5, 9)
    found, given = (
        ConfusionDisplay.from_predictions(["a", "b"], ["b", "b"], poses, skeleton, projection=one)
        for one in (None, projection)
    )
    for ax, other in zip(found.strip_axes_[0], given.strip_axes_[0], strict=True):
        np.testing.assert_array_equal(figures_of(ax), figures_of(other))


def test_confused_cells_have_a_frame(display):
    cells = {(patch.get_y() + 0.5, patch.get_x() + 0.5) for patch in display.matrix_ax_.patches}
    assert cells == {(display.labels.index(o.true), display.labels.index(o.predicted)) for o in display.shown_}


def test_nothing_overlaps(display):
    matrix = display.matrix_ax_.get_tightbbox()
    boxes = [text.get_window_extent() for text in texts_in_strips(display)]
    assert all(box.x0 > matrix.x1 for box in boxes)
    assert all(box.x1 <= display.figure_.bbox.x1 for box in boxes)
    whole = display.figure_.bbox
    assert matrix.x0 >= whole.x0
    assert matrix.y0 >= whole.y0
    figures = [line.get_window_extent() for both in display.strip_axes_ for ax in both for line in ax.lines]
    assert not any(figure.overlaps(box) for figure in figures for box in boxes)


def test_long_names_have_room_at_once():
    """A square matrix and its labels are in the figure before it is drawn again, as notebooks draw it once."""
    names = np.array([f"{word} both arms backward, {word}" for word in "abcdefghijk"])
    y_true = np.repeat(names, 2)
    X = RNG.normal(size=(22, 2))
    display = ConfusionDisplay.from_predictions(y_true, np.roll(y_true, 1), X, Skeleton.chain(2))
    box, whole = display.matrix_ax_.get_tightbbox(), display.figure_.bbox
    assert (box.min >= 0).all()
    assert (box.max <= whole.max).all()


def texts_in_strips(display):
    return [text for ax in display.figure_.axes if ax is not display.matrix_ax_ for text in texts_of(ax)]


def test_classes_that_are_confused_are_adjacent():
    X = RNG.normal(size=(60, 2))
    y_true = np.repeat(list("abcdef"), 10)
    y_pred = y_true.copy()
    y_pred[:4], y_pred[50:55], y_pred[10:13] = "f", "a", "d"
    display = ConfusionDisplay.from_predictions(y_true, y_pred, X, Skeleton.chain(2))
    assert display.labels == ["a", "f", "b", "d", "c", "e"]
    y_pred[50:55], y_pred[20:24], y_pred[31:35] = "d", "f", "b"  # a chain: a with f with d with b, and f with c
    display = ConfusionDisplay.from_predictions(y_true, y_pred, X, Skeleton.chain(2))
    rows = {label: row for row, label in enumerate(display.labels)}
    assert abs(rows["d"] - rows["b"]) == abs(rows["a"] - rows["f"]) == abs(rows["f"] - rows["c"]) == 1
    assert rows["e"] == 5
    given = list("fedcba")
    display = ConfusionDisplay.from_predictions(y_true, y_pred, X, Skeleton.chain(2), labels=given)
    assert display.labels == given
    np.testing.assert_array_equal(numbers_of(display), confusion_matrix(y_true, y_pred, labels=given))


def test_the_nearest_is_of_the_training_motions(gait):
    test, train = gait[:4], gait[4:]
    predicted = ["run", "walk", "hop", "skip"]
    given = {"X_train": train, "y_train": train.actions}
    display = ConfusionDisplay.from_predictions(test.actions, predicted, test, metric="position", **given)
    D = motion_distances(test, train, metric="position", skeleton=display.skeleton)
    for one in display.confusions:
        of_class = [j for j in range(8) if train.actions[j] == one.predicted]
        assert one.nearest == min(of_class, key=lambda j: D[one.sample, j])
        assert one.distance == pytest.approx(D[one.sample, one.nearest], rel=1e-12)
    assert labels_of(display, 0)[3].split("\n")[1] == (
        f"training motion {display.shown_[0].nearest}, subject {train.subjects[display.shown_[0].nearest]}"
    )
    random = RNG.random((4, 8))
    display = ConfusionDisplay.from_predictions(test.actions, predicted, test, distances=random, **given)
    for one in display.confusions:
        of_class = [j for j in range(8) if train.actions[j] == one.predicted]
        assert (one.nearest, one.distance) == min(
            ((j, random[one.sample, j]) for j in of_class), key=lambda both: both[1]
        )


def test_distances_among_the_motions_leave_out_the_same_person(gait):
    D = RNG.random((12, 12))
    np.fill_diagonal(D, [1e-8, np.inf] * 6)  # rounded, or left out
    for subjects in (gait.subjects, ["anna"] * 8 + ["ben"] * 4):
        display = ConfusionDisplay.from_predictions(
            gait.actions, PREDICTED, gait.motions, subjects=subjects, distances=D
        )
        for one in display.confusions:
            others = [j for j in range(12) if gait.actions[j] == one.predicted and subjects[j] != subjects[one.sample]]
            assert one.nearest == min(others, key=lambda j: D[one.sample, j])


def test_without_another_person_there_is_no_nearest(gait):
    display = ConfusionDisplay.from_predictions(gait.actions, PREDICTED, gait, subjects=["anna"] * 12)
    assert {one.nearest for one in display.confusions} == {None}
    assert np.isnan([one.distance for one in display.confusions]).all()
    assert labels_of(display, 0)[3].endswith("none of others in X")
    assert [len(ax.lines) > 0 for ax in display.strip_axes_[0]] == [True, False]
    display = ConfusionDisplay.from_predictions(["a"] * 12, ["b"] * 12, gait.motions)
    assert labels_of(display, 0)[3] == "b\nnone in X"


def test_poses_are_side_by_side_above_their_nearest():
    X = RNG.normal(size=(40, 2))
    arm = Skeleton.chain(2)
    y_true, y_pred = np.repeat(["down", "up"], 20), np.repeat(["down", "up", "up"], [10, 10, 20])
    display = ConfusionDisplay.from_predictions(y_true, y_pred, X, arm, n_poses=4)
    D = pose_distances(X, skeleton=arm)
    for one in display.confusions:
        assert one.nearest == 20 + D[one.sample, 20:].argmin()
        assert one.distance == pytest.approx(D[one.sample, one.nearest], rel=1e-12)
    assert display.shown_ == display.confusions[:4]
    for ax, part in zip(display.strip_axes_[0], ("sample", "nearest"), strict=True):
        joints = forward_kinematics(X[[getattr(one, part) for one in display.shown_]], arm)[:, :, :2]
        np.testing.assert_allclose(figures_of(ax), [sorted(pose.tolist()) for pose in joints], atol=1e-12)
    assert display.matrix_ax_.get_title(loc="left") == "30 of 40 poses recognised, 75.0%"


def test_no_confusions_are_said_in_words(gait):
    display = ConfusionDisplay.from_predictions(gait.actions, gait.actions, gait)
    assert display.confusions == display.strip_axes_ == display.shown_ == []
    np.testing.assert_array_equal(numbers_of(display), 3 * np.eye(4))
    (words,) = texts_in_strips(display)
    assert words.get_text() == "no confusions:\nall 12 motions\nhave their own class"


def test_given_axes_style_and_numbers(gait):
    figure, (ax, other) = plt.subplots(1, 2, figsize=(16, 6))
    display = ConfusionDisplay.from_predictions(
        gait.actions, PREDICTED, gait, ax=ax, n_pairs=1, n_poses=3, projection="zy", color="#123456", lw=3
    )
    figure.canvas.draw()
    assert display.ax_ is ax
    assert display.figure_ is figure
    assert len(display.strip_axes_) == 1
    for strip in display.strip_axes_[0]:
        assert len(figures_of(strip)) == 3
        assert {(to_hex(line.get_color()), line.get_linewidth()) for line in strip.lines} == {("#123456", 3)}
    slot = ax.get_window_extent()
    assert all(text.get_window_extent().x1 <= slot.x1 for text in texts_in_strips(display))
    again = display.plot(other)
    assert again is display
    assert len(display.strip_axes_) == 3


def test_numbers_as_classes(gait):
    codes = np.array([NAMES.index(action) for action in gait.actions])
    predicted = np.array([NAMES.index(action) for action in PREDICTED])
    display = ConfusionDisplay.from_predictions(codes, predicted, gait)
    assert {type(label) for label in display.labels} == {int}
    assert isinstance(display.confusions[0], Confusion)
    np.testing.assert_array_equal(display.confusion_matrix, confusion_matrix(codes, predicted, labels=display.labels))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"y_true": ["walk"] * 3}, "y_true must have one value for each of the 12 motions of X, got shape (3,)"),
        ({"y_pred": ["walk"] * 13}, "y_pred must have one value for each of the 12 motions of X, got shape (13,)"),
        ({"subjects": ["anna"]}, "subjects must have one value for each of the 12 motions of X, got shape (1,)"),
        ({"labels": ["walk", "run", "skip"]}, "labels must be all classes, got none that is 'hop', as in y_true"),
        ({"labels": ["walk", "run", "skip", "hop", "hop"]}, "labels must be different classes"),
        ({"distances": np.zeros((12, 3))}, "distances must have shape (12, 12), from each motion of X to each of X"),
        ({"distances": np.full((12, 12), np.nan)}, "distances must be numbers, got 144 NaN"),
        ({"distances": 0.1 - np.eye(12)}, "distances must not be negative, got -0.9: if it is a kernel"),
        ({"distances": 0.1 + np.eye(12)}, "to themselves must be zero, got 1.1 for motion 0: a kernel"),
        ({"y_train": ["walk"] * 12}, "X_train and y_train belong together"),
        ({"n_pairs": 0}, "n_pairs must be a whole number of at least 1"),
        ({"n_poses": 0}, "n_poses must be a whole number of at least 1"),
        ({"projection": "zz"}, "projection must be two of the axes"),
    ],
)
def test_refuses_in_words(gait, changed, message):
    given = {"y_true": gait.actions, "y_pred": PREDICTED, "X": gait, "metric": "position"} | changed
    with pytest.raises(ValueError, match=re.escape(message)):
        ConfusionDisplay.from_predictions(**given)


def test_refuses_training_motions_that_do_not_fit(gait):
    given = gait.actions, PREDICTED, gait
    with pytest.raises(ValueError, match=re.escape("y_train must have one value for each of the 5 motions of X_train")):
        ConfusionDisplay.from_predictions(*given, X_train=gait[:5], y_train=gait.actions)
    with pytest.raises(ValueError, match="y_pred has 'hop', which is no class of y_train"):
        ConfusionDisplay.from_predictions(*given, X_train=gait[:2], y_train=gait.actions[:2])
    with pytest.raises(ValueError, match="ConfusionDisplay needs the skeleton of arrays to draw them: pass skeleton="):
        ConfusionDisplay.from_predictions(*given[:2], [motion.angles for motion in gait])
    with pytest.raises(TypeError, match="X must be motions"):
        ConfusionDisplay.from_predictions(*given[:2], "folder")


def test_refuses_axes_outside_a_grid(gait):
    figure = plt.figure()
    with pytest.raises(ValueError, match="ax must be one of a grid"):
        ConfusionDisplay.from_predictions(gait.actions, PREDICTED, gait, ax=figure.add_axes((0, 0, 1, 1)))
