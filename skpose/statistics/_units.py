"""The two sets of a test as exchangeable units: single poses or whole motions."""

from typing import Any, NamedTuple

import numpy as np

from skpose._utils.validation import check_poses
from skpose._utils.warnings import warn
from skpose.metrics import Metric
from skpose.metrics._motion_metrics import MotionMetric
from skpose.motions._base import is_rows
from skpose.motions._inputs import CheckedMotions, Sequences, check_motions
from skpose.skeleton import Skeleton

FRAMES_OF_A_RECORDING = 0.4  # threshold of `_warn_of_frames`, above the ratio of most recordings


class Units(NamedTuple):
    """The units of both sets."""

    X: CheckedMotions  # a pose is a motion of one frame
    Y: CheckedMotions
    skeleton: Skeleton | None
    are_rows: bool  # whether units are single poses

    @property
    def n_x(self) -> int:
        return self.X.sequences.n_motions

    @property
    def n_y(self) -> int:
        return self.Y.sequences.n_motions

    @property
    def name(self) -> str:
        """The plural noun for a unit."""
        return "poses" if self.are_rows else "motions"

    def encode(self, metric: Metric) -> tuple[Sequences, Sequences]:
        """The rows that the metric compares, for X and Y."""
        if self.are_rows and isinstance(metric, MotionMetric):
            raise ValueError(f"the metric {metric.label!r} needs lists of motions, got arrays of poses")
        return self.X.rows(metric, "X"), self.Y.rows(metric, "Y")


def check_units(X: Any, Y: Any, skeleton: Skeleton | None, paired: bool) -> Units:
    """Validate X and Y, and put them on one skeleton."""
    rows = is_rows(X)
    if rows != is_rows(Y):
        kinds = ("poses", "motions") if rows else ("motions", "poses")
        raise ValueError(
            f"X and Y must both be arrays of poses or both lists of motions, got {kinds[0]} and {kinds[1]}"
        )
    if rows:
        a, b = check_poses(X, skeleton, "X"), check_poses(Y, skeleton, "Y")
        if a.shape[1] != b.shape[1]:
            raise ValueError(f"X and Y must have the same number of columns, got {a.shape[1]} and {b.shape[1]}")
        one, other = (CheckedMotions(Sequences(p, np.arange(len(p) + 1)), skeleton, None) for p in (a, b))
    else:
        one, other = check_motions({"X": X, "Y": Y}, skeleton)
    units = Units(one, other, one.skeleton, rows)
    if paired and units.n_x != units.n_y:
        raise ValueError(f"paired=True needs as many {units.name} in X as in Y, got {units.n_x} and {units.n_y}")
    if units.n_x == units.n_y == 1:
        raise ValueError(f"X or Y must have at least two {units.name}, got one each")
    if rows:
        _warn_of_frames(X=a, Y=b)
    return units


def _warn_of_frames(**arrays: np.ndarray) -> None:
    """Warn if rows seem to be consecutive frames of a recording.

    Uses half the ratio of J. von Neumann, "Distribution of the ratio of the mean square successive difference to the
    variance", Annals of Mathematical Statistics 12(4), 1941, :doi:`10.1214/aoms/1177731677`: the mean squared step from
    row to row over that between random rows. Its mean over all orders is 1, its standard deviation at most about 1 /
    √n.
    """
    for name, X in arrays.items():
        if len(X) < 2:
            continue
        steps = np.square(np.diff(X, axis=0), dtype=np.float64).sum(axis=1).mean()
        ratio = steps / max(2.0 * np.var(X, axis=0, ddof=1, dtype=np.float64).sum(), np.finfo(np.float64).tiny)
        if steps > 0 and ratio < min(FRAMES_OF_A_RECORDING, 1.0 - 4.0 / np.sqrt(len(X))):
            warn(
                f"rows of {name} look like consecutive frames, so p is too small: pass a list of motions, "
                f"which are permuted as wholes (mean square step {ratio:.2g} of that in random order)"
            )
            return
