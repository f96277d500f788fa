from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import FillBetweenPolyCollection

from skpose.biomechanics import GaitEvents, JointAngles
from skpose.motions import Repetitions
from skpose.plot import JointAnglesDisplay
from skpose.plot._axes import SIDES

pytestmark = pytest.mark.usefixtures("agg")


RATE, N = 50.0, 400


NAMES = "pelvis_tilt", "hip_flexion_left", "hip_flexion_right", "knee_flexion_left", "knee_flexion_right"
NAMES += "ankle_dorsiflexion_left", "ankle_dorsiflexion_right"


PERCENT = np.arange(101)


CYCLES = np.array([[10, 90], [90, 175], [175, 250], [300, 390]])


def some_angles(seed=0, times=None, **changed):
    """Smooth curves of seven angles, of which some may be others."""
    rng = np.random.default_rng(seed)
    times = np.arange(N) / RATE if times is None else times
    waves = [np.sin(2 * np.pi * (k * times / 8 + rng.uniform())) * rng.uniform(5, 30) for k in rng.integers(3, 9, 7)]
    degrees = np.stack(waves, axis=1)
    for name, values in changed.items():
        degrees[:, NAMES.index(name)] = values
    return JointAngles(NAMES, degrees, times, "rest pose", {})


def some_events(lefts, rights, motion_times=None):
    """Strides between contacts at these times, s, of each foot."""
    times = np.concatenate([lefts, rights])
    feet = np.array(["left"] * len(lefts) + ["right"] * len(rights))
    numbers = [np.flatnonzero(feet == side) for side in ("left", "right")]
    strides = [[a, 0, b] for of in numbers for a, b in pairwise(of)]
    return GaitEvents(
        feet=feet,
        kinds=np.full(len(times), "foot contact"),
        times=times,
        frames=np.rint(times * RATE).astype(int),
        positions=np.zeros((len(times), 3)),
        strides=np.array(strides).reshape(-1, 3),
        joints={f"{side}_{part}": part for side in ("left", "right") for part in ("ankle", "toe")},
        frame_rate=RATE,
        up="y",
        reason="the feet do not move",
        motion_times=np.arange(N) / RATE if motion_times is None else motion_times,
    )


def some_repetitions(times, cycles=CYCLES):
    starts, stops = cycles.T
    nothing = np.zeros(len(starts))
    return Repetitions(starts, stops, nothing, 0, 0.5, 0.01, [], None, times)


def curves_of(values, spans):
    """Values at each percent of each cycle, by plain numpy."""
    times = np.arange(N) / RATE
    return np.stack([np.interp(np.linspace(first, last, 101), times, values) for first, last in spans])


def lines_of(ax, side):
    """The curves of a side: not the line of zero."""
    return [line.get_ydata() for line in ax.lines if line.get_color() == SIDES[side] and len(line.get_ydata()) > 2]


def band_of(ax, side):
    """The lower and the upper edge of a side's band."""
    colour = plt.matplotlib.colors.to_rgb(SIDES[side])
    (band,) = [
        one
        for one in ax.collections
        if isinstance(one, FillBetweenPolyCollection) and tuple(one.get_facecolor()[0][:3]) == colour
    ]
    edges = {}
    for path in band.get_paths():
        for x, y in path.vertices:
            edges.setdefault(round(x), []).append(y)
    return np.array([[min(edges[k]), max(edges[k])] if k in edges else [np.nan] * 2 for k in PERCENT]).T


def assert_drawn(ax, side, curves):
    """One line and one band are the mean and the standard deviation of the curves."""
    (line,) = lines_of(ax, side)
    mean, std = curves.mean(axis=0), curves.std(axis=0, ddof=1)
    np.testing.assert_allclose(line, mean, atol=1e-9)
    np.testing.assert_allclose(band_of(ax, side), [mean - std, mean + std], atol=1e-9)


def labels_of(display):
    (legend,) = [ax.get_legend() for ax in display.figure_.axes if ax.get_legend()]
    return [text.get_text() for text in legend.get_texts()]


@pytest.mark.parametrize("kind", ["list", "repetitions"])
def test_cycles_are_the_same_for_both_sides(kind):
    angles = some_angles()
    cycles = {
        "list": CYCLES.tolist(),
        "repetitions": some_repetitions(angles.times),
    }[kind]
    display = JointAnglesDisplay.from_angles(angles, cycles, names=["hip_flexion", "pelvis_tilt", "knee_flexion_right"])
    assert list(display.axes_) == ["hip_flexion", "pelvis_tilt", "knee_flexion_right"]
    spans = angles.times[CYCLES - [0, 1]]  # the frame behind the last is no part of a cycle
    for name, sides in {
        "hip_flexion": ("left", "right"),
        "pelvis_tilt": ("",),
        "knee_flexion_right": ("right",),
    }.items():
        ax = display.axes_[name]
        for side in sides:
            column = name if name in NAMES else f"{name}_{side}"
            assert_drawn(ax, side, curves_of(angles[column], spans))
        assert not any(lines_of(ax, side) for side in SIDES if side not in sides)
        assert ax.get_title(loc="left") == name.replace("_", " ")
        assert ax.get_xlim() == (0, 100)
    noun = "repetition" if "repetitions" in kind else "cycle"
    assert labels_of(display) == [f"{side}, 4 {noun}s" for side in ("left", "right", "middle")] + [
        "± standard deviation"
    ]
    assert display.axes_["hip_flexion"].get_xlabel() == f"{noun} (%)"
    assert display.axes_["hip_flexion"].get_ylabel() == "degrees"


@pytest.mark.parametrize(("lefts", "rights", "more"), [([1.0, 2.2], [0.3, 1.6, 2.9], "right")])
def test_each_side_has_its_own_strides(lefts, rights, more):
    """The middle has those of the foot with more of them."""
    angles, contacts = some_angles(1), {"left": np.array(lefts), "right": np.array(rights)}
    display = JointAnglesDisplay.from_angles(angles, some_events(lefts, rights), names=["hip_flexion", "pelvis_tilt"])
    for side, name in {"left": "hip_flexion", "right": "hip_flexion", "": "pelvis_tilt"}.items():
        times = contacts[side or more]
        curves = curves_of(angles[f"{name}_{side}" if side else name], np.stack([times[:-1], times[1:]], axis=1))
        if len(curves) > 1:
            assert_drawn(display.axes_[name], side, curves)
        else:
            np.testing.assert_allclose(lines_of(display.axes_[name], side), curves, atol=1e-9)
            assert np.isnan(band_of(display.axes_[name], side)).all()
    counts = {side: len(times) - 1 for side, times in contacts.items()}
    words = [f"{side}, {n} stride{'s' * (n > 1)}" for side, n in counts.items()]
    assert labels_of(display)[:3] == [*words, f"middle, {counts[more]} strides of the {more}"]
    assert display.axes_["pelvis_tilt"].get_xlabel() == "stride (%)"


def test_no_curve_across_missing_frames():
    """0.06 s without frames are interpolated, 0.5 s are not."""
    numbers = np.r_[0:100, 102:200, 225 : N + 27]
    angles = some_angles(times=numbers / RATE)
    display = JointAnglesDisplay.from_angles(angles, [(50, 150), (150, 250)], names=["pelvis_tilt"], show_cycles=True)
    one, other = lines_of(display.axes_["pelvis_tilt"], "")[:2]
    assert np.isfinite(one).all()
    at = np.linspace(angles.times[150], angles.times[249], 101)
    inside = (at > 199 / RATE) & (at < 225 / RATE)
    assert inside.sum() > 10
    np.testing.assert_array_equal(np.isnan(other), inside)


def test_a_jump_of_a_whole_turn_is_none():
    """Cycles around 180°, in some of which the angle is written as below -180°."""
    phase = np.arange(N) / 40
    smooth = 175 + 10 * np.sin(2 * np.pi * phase)
    angles = some_angles(pelvis_tilt=(smooth + 180) % 360 - 180)
    cycles = np.array([[0, 40], [40, 80], [80, 120]])
    spans = angles.times[cycles - [0, 1]]
    display = JointAnglesDisplay.from_angles(angles, cycles, names=["pelvis_tilt"])
    assert_drawn(display.axes_["pelvis_tilt"], "", curves_of(smooth, spans))


def test_each_cycle_can_be_drawn():
    angles = some_angles()
    display = JointAnglesDisplay.from_angles(angles, CYCLES, names=["pelvis_tilt"], show_cycles=True)
    curves = curves_of(angles["pelvis_tilt"], angles.times[CYCLES - [0, 1]])
    np.testing.assert_allclose(lines_of(display.axes_["pelvis_tilt"], ""), [*curves, curves.mean(axis=0)], atol=1e-9)
    assert not display.axes_["pelvis_tilt"].collections
    assert labels_of(display) == ["middle, 4 cycles"]


def test_without_cycles_curves_over_time():
    angles = some_angles()
    display = JointAnglesDisplay.from_angles(angles, names=["hip_flexion"])
    ax = display.axes_["hip_flexion"]
    for side in ("left", "right"):
        np.testing.assert_allclose(lines_of(ax, side), [angles[f"hip_flexion_{side}"]], atol=1e-9)
    assert (ax.get_xlabel(), ax.get_xlim()) == ("time (s)", (0.0, angles.times[-1]))
    assert labels_of(display) == ["left", "right"]


@pytest.mark.parametrize(
    "cycles",
    [
        np.zeros((0, 2), int),
        [[0.0, 20.0]],
        [[0, 40], [30, 31]],
        [[0, N + 1]],
        some_repetitions(np.arange(N) / RATE + 1),
        some_events([], []),
        some_events([1.0, 2.2], [], np.arange(N) / RATE + 1),
    ],
    ids=range(7),
)
def test_cycles_must_be_of_the_recording(cycles):
    with pytest.raises(ValueError, match="cycles"):
        JointAnglesDisplay.from_angles(some_angles(), cycles)


def test_unknown_names_are_refused():
    with pytest.raises(ValueError, match="names"):
        JointAnglesDisplay.from_angles(some_angles(), CYCLES, names=["knee"])


def test_tables_of_cycles_are_drawn_as_the_cycles_themselves():
    angles, names = some_angles(), ["hip_flexion", "pelvis_tilt"]
    table = angles.cycles(CYCLES).assign(trial=0)
    both = pd.concat([table, table.assign(trial=1)])  # cycle 0 of one trial is not that of the other
    for given in (both, both.sample(frac=1.0, random_state=0)):
        display = JointAnglesDisplay.from_angles(given, names=names)
        for side, name in {"left": "hip_flexion_left", "": "pelvis_tilt"}.items():
            curves = curves_of(angles[name], angles.times[CYCLES - [0, 1]])
            assert_drawn(display.axes_[names[side == ""]], side, np.concatenate([curves, curves]))
        assert labels_of(display)[0] == "left, 8 cycles"


def test_norm_is_a_band_behind_the_curves():
    angles = some_angles()
    phases = np.linspace(100, 0, 51)
    norm = pd.DataFrame({"angle": "hip_flexion", "phase [%]": phases, "mean": phases / 4, "std": 5.0})
    display = JointAnglesDisplay.from_angles(angles, CYCLES, norm=norm, names=["hip_flexion", "pelvis_tilt"])
    for name, n_bands in {"hip_flexion": 3, "pelvis_tilt": 2}.items():
        bands = [
            len(one.get_paths()[0].vertices) > 4 if one.get_paths() else False
            for one in display.axes_[name].collections
        ]
        assert len(bands) == n_bands
    edges = display.axes_["hip_flexion"].collections[0].get_paths()[0].vertices
    low, high = edges[edges[:, 0] == 50.0][:, 1].min(), edges[edges[:, 0] == 50.0][:, 1].max()
    assert (low, high) == (7.5, 17.5)
    assert labels_of(display)[-1] == "norm ± standard deviation"
    with pytest.raises(ValueError, match="norm needs cycles"):
        JointAnglesDisplay.from_angles(angles, norm=norm)
