import re
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import LineCollection
from scipy.spatial.transform import Rotation

from skpose import Motion
from skpose.datasets import humanoid
from skpose.motions import Repetitions
from skpose.plot import RepetitionsDisplay

pytestmark = pytest.mark.usefixtures("agg")

SKELETON, RATE, FRAMES = humanoid(), 50.0, 60
DEEP = {"thigh_rx": -1.6, "shank_rx": 2.0, "foot_rx": -0.5}
WRONG = 3


def squats(n=6, dof="left_thigh_ry", degrees=15.0, **root):
    """Squats of which one has a knee, or another joint, off in the middle."""
    rng = np.random.default_rng(0)
    phase = np.linspace(0, 1, FRAMES)
    deep = np.zeros(SKELETON.n_dofs)
    for name, angle in DEEP.items():
        deep[[SKELETON.dof_names.index(f"{side}_{name}") for side in ("left", "right")]] = angle
    poses = [np.sin(np.pi * phase)[:, None] * (deep + 0.02 * rng.normal(size=deep.shape)) for _ in range(n)]
    if n > WRONG:
        off = np.radians(degrees) * np.exp(-(((phase - 0.5) / 0.05) ** 2))
        poses[WRONG][:, SKELETON.dof_names.index(dof)] -= off
    recording = Motion(SKELETON, np.concatenate(poses), RATE, **root)
    starts = FRAMES * np.arange(n)
    motions = [recording[start : start + FRAMES] for start in starts]
    nothing = np.zeros((0, 2), int)
    return Repetitions(starts, starts + FRAMES, np.zeros(n), 0, 0.5, 0.01, nothing, motions, SKELETON, recording.times)


@pytest.fixture(scope="module")
def found():
    return squats()


def bones_of(display):
    """The ends (n_poses, n_joints, 2, 2) of the bones in colour, and their values."""
    (lines,) = [one for one in display.ax_.collections if isinstance(one, LineCollection)]
    n = SKELETON.n_joints
    return np.array(lines.get_segments()).reshape(-1, n, 2, 2), lines.get_array().reshape(-1, n), lines


def table_of(found, k, n_phases=20):
    table = found.to_pandas(n_phases=n_phases)
    return table, table[table["repetition"] == k].set_index(["phase [%]", "joint"])


def phases_of(display):
    return [label.get_text() for label in display.ax_.get_xticklabels()]


def test_shows_the_first_row_of_the_table_by_unusual(found):
    display = RepetitionsDisplay.from_repetitions(found)
    row = found.to_pandas().sort_values("unusual", ascending=False).iloc[0]
    assert display.repetition_ == row["repetition"] == WRONG
    assert (display.joint_, display.phase_, display.deviation_) == (
        row["joint"],
        row["phase [%]"],
        row["deviation [m]"],
    )
    assert display.joint_.startswith("left_")
    first, second = display.ax_.get_title(loc="left").split("\n")
    size, ratio = 100 * row["deviation [m]"], row["unusual"]
    assert first == f"repetition 3 of 0 to 5: {row['joint']} {size:.1f} cm off, {ratio:.1f} times the usual,"
    when = f"at {row['phase [%]']:.3g} % of the movement, {row['time [s]']:.2f} s"
    assert second == f"{when}; seen from the front"


@pytest.mark.parametrize(("repetition", "n_poses", "n_phases"), [(None, 6, 20), (1, 4, 20), (-1, 3, 7), (0, 50, 5)])
def test_bones_have_the_deviation_of_the_joint_at_their_end(found, repetition, n_poses, n_phases):
    display = RepetitionsDisplay.from_repetitions(found, repetition=repetition, n_poses=n_poses, n_phases=n_phases)
    k = WRONG if repetition is None else repetition % 6
    whole, table = table_of(found, k, n_phases)
    ends, values, lines = bones_of(display)
    assert len(values) == len(phases_of(display)) == min(n_poses, n_phases)
    assert lines.get_clim() == (0, pytest.approx(100 * whole["deviation [m]"].max()))
    phases = np.unique(whole["phase [%]"])
    shown = [phases[np.argmin(np.abs(phases - float(label.split(" ")[0])))] for label in phases_of(display)]
    assert display.phase_ in shown
    assert (np.diff(shown) > 0).all()
    for phase, label, colours in zip(shown, phases_of(display), values, strict=True):
        rows = table.loc[phase].loc[list(SKELETON.joint_names)]
        np.testing.assert_allclose(colours, 100 * rows["deviation [m]"], rtol=1e-12)
        assert label.split("\n")[1] == f"{rows['time [s]'].iloc[0]:.2f} s"
    parents = np.array(SKELETON.parents)
    joined = parents >= 0
    np.testing.assert_allclose(ends[:, joined, 0], ends[:, parents[joined], 1], atol=1e-12)


def test_the_typical_one_is_where_the_vectors_of_the_table_begin(found):
    display = RepetitionsDisplay.from_repetitions(found, n_poses=1)
    assert phases_of(display)[0].startswith(f"{display.phase_:.3g} %")
    _, table = table_of(found, WRONG)
    rows = table.loc[display.phase_].loc[list(SKELETON.joint_names)]
    ends, _, _ = bones_of(display)
    grey = [line for line in display.ax_.lines if line.get_color() == "0.82"]
    points = np.concatenate([np.stack(line.get_data(), axis=1).reshape(-1, 3, 2)[:, 1] for line in grey])
    vectors = rows[[f"{axis} [m]" for axis in display.projection_]].to_numpy()
    np.testing.assert_allclose(ends[0, :, 1] - points, vectors, atol=1e-12)


def test_poses_fill_the_picture(found):
    """Equal units make one direction wider than the poses need, and not both."""
    display = RepetitionsDisplay.from_repetitions(found)
    display.figure_.canvas.draw()
    data = display.ax_.dataLim
    wide = np.ptp(display.ax_.get_xlim()) / data.width, np.ptp(display.ax_.get_ylim()) / data.height
    assert min(wide) < 1.15


def test_the_side_is_named_where_a_repetition_lacks_phases(found):
    """The first one begins late: the others have phases that it lacks."""
    starts = found.starts.copy()
    starts[0] += FRAMES // 4
    late = replace(found, starts=starts, motions=[found.motions[0][FRAMES // 4 :], *found.motions[1:]])
    display = RepetitionsDisplay.from_repetitions(late, repetition=0)
    assert table_of(late, 0)[1].shape[0] < table_of(found, 0)[1].shape[0]
    assert "; seen from" in display.ax_.get_title(loc="left")


def test_a_ring_marks_the_joint(found):
    display = RepetitionsDisplay.from_repetitions(found)
    (ring,) = [line for line in display.ax_.lines if line.get_markerfacecolor() == "none"]
    ends, _, _ = bones_of(display)
    column = [label.split(" ")[0] for label in phases_of(display)].index(f"{display.phase_:.3g}")
    joint = SKELETON.joint_names.index(display.joint_)
    np.testing.assert_allclose(np.ravel(ring.get_data()), ends[column, joint, 1], atol=1e-12)


@pytest.mark.parametrize(
    ("dof", "seen", "projection"),
    [("left_thigh_ry", "the front", "xy"), ("left_upper_arm_rx", "the right", "zy")],
)
def test_seen_from_where_it_shows(dof, seen, projection):
    display = RepetitionsDisplay.from_repetitions(squats(dof=dof, degrees=25.0))
    assert display.projection_ == projection
    assert display.ax_.get_title(loc="left").endswith(f"seen from {seen}")
    assert display.ax_.get_ylabel() == "y (m)"


@pytest.mark.parametrize(
    ("projection", "seen"), [("yx", ""), ("zy", "; seen from the right"), ("xy", "; seen from the front")]
)
def test_another_projection(found, projection, seen):
    display = RepetitionsDisplay.from_repetitions(found, projection=projection)
    assert display.projection_ == projection
    assert display.ax_.get_title(loc="left").endswith(f" s{seen}")


def test_the_vertical_of_the_world_is_upright():
    """A root whose own x points up in the world."""
    turn = Rotation.from_euler("z", 90, degrees=True).as_euler("xyz")
    angles = np.tile(turn, (6 * FRAMES, 1))
    display = RepetitionsDisplay.from_repetitions(squats(root_angles=angles, root_axes="xyz"))
    assert display.projection_[1] == "x"


def test_figures_do_not_overlap_and_keep_their_shape(found):
    display = RepetitionsDisplay.from_repetitions(found, projection="zy")
    display.figure_.canvas.draw()
    ends, _, _ = bones_of(display)
    low, high = ends[..., 0].min(axis=(1, 2)), ends[..., 0].max(axis=(1, 2))
    assert (low[1:] > high[:-1]).all()
    assert display.ax_.get_aspect() == 1.0
    boxes = [label.get_window_extent() for label in display.ax_.get_xticklabels()]
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
    title = display.ax_._left_title.get_window_extent()
    assert display.figure_.bbox.x0 <= title.x0
    assert title.x1 <= display.figure_.bbox.x1


def test_few_repetitions_and_arrays_say_less():
    """Three have no spread, and arrays no times."""
    found = squats(n=5)
    rest = [one.angles for one in found.motions[1:4]]
    few = replace(found, starts=found.starts[1:4], stops=found.stops[1:4], motions=rest, times=None)
    display = RepetitionsDisplay.from_repetitions(few)
    table = few.to_pandas()
    row = table.loc[table["deviation [m]"].idxmax()]
    assert (display.repetition_, display.joint_, display.phase_) == (row["repetition"], row["joint"], row["phase [%]"])
    title = display.ax_.get_title(loc="left")
    assert "usual" not in title
    assert " s" not in title.split("\n")[1].partition(";")[0]
    assert not any("s" in label for label in phases_of(display))


def test_style_and_given_axes(found):
    _, ax = plt.subplots()
    display = RepetitionsDisplay.from_repetitions(found, ax=ax, cmap="viridis", vmax=20.0, linewidths=4.0)
    _, _, lines = bones_of(display)
    assert display.ax_ is ax
    assert (lines.get_cmap().name, lines.get_clim(), lines.get_linewidth()) == ("viridis", (0.0, 20.0), [4.0])


def test_refuses_what_cannot_be_drawn(found):
    with pytest.raises(ValueError, match="repetition must be one of the 6 that there are, 0 to 5, got 6"):
        RepetitionsDisplay.from_repetitions(found, repetition=6)
    with pytest.raises(ValueError, match="repetition must be a whole number"):
        RepetitionsDisplay.from_repetitions(found, repetition=-7)
    with pytest.raises(ValueError, match="projection must be two of the axes"):
        RepetitionsDisplay.from_repetitions(found, projection="zz")
    with pytest.raises(ValueError, match="n_poses must be a whole number"):
        RepetitionsDisplay.from_repetitions(found, n_poses=0)
    one = replace(found, starts=found.starts[:1], stops=found.stops[:1], motions=found.motions[:1])
    with pytest.raises(
        ValueError, match="RepetitionsDisplay compares repetitions with each other and needs at least two"
    ):
        RepetitionsDisplay.from_repetitions(one)
    with pytest.raises(ValueError, match="RepetitionsDisplay needs a skeleton"):
        RepetitionsDisplay.from_repetitions(replace(found, skeleton=None))
    with pytest.raises(TypeError, match=re.escape("repetitions must be a skpose.motions.Repetitions, got list")):
        RepetitionsDisplay.from_repetitions(found.motions)
