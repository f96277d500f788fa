"""Poses as short vectors, whose distances bound a metric from below at a thousandth of its cost.

A chord is never longer than a curve, so ‖F(a) − F(b)‖ bounds "spatial" and "geodesic" from below, whatever the triangle
inequality, and it is tight. Orthonormal axes V split it without loss: with F = Vz + rest,
‖F(a) − F(b)‖² = ‖z(a) − z(b)‖² + ‖rest(a) − rest(b)‖² ≥ ‖z(a) − z(b)‖² + (‖rest(a)‖ − ‖rest(b)‖)².
Along the first principal axes of the joint positions the first term is nearly all of it. A `Screen` holds z and ‖rest‖
of every pose in float32.

Rounding: coordinates of norm r and q are rounded by a relative 2⁻²⁴ at most, which moves their distance by no more than
2⁻²⁴ (r + q); the distance itself, no more than r + q, is computed with a relative error below 16 · 2⁻²⁴. What float64
adds, in ‖rest‖² = ‖F‖² − ‖z‖² above all, is a few more 2⁻²⁴ (r + q). So no bound is too high once its *slack*, about
thrice all this, is taken off.
"""

import numpy as np

from skpose._compiled import loops
from skpose._compiled.lanes import lanes
from skpose._compiled.results import aligned
from skpose._compiled.tree import Steps
from skpose.metrics._matrix import PANEL
from skpose.metrics._registry import METRICS
from skpose.skeleton import Skeleton

N_AXES = 17  # and the rest: a multiple of three, as `measure_euclidean` takes three at a time
SAMPLE = 4096  # poses from which the axes are taken
ROUNDING = 64 * 2.0**-24
IN_RANGE = 1e15  # in units of the screen; float32 cannot add up squares of much more
FLOAT32 = np.dtype(np.float32)


class Screen:
    """The screen of an index's poses.

    Parameters
    ----------
    poses : ndarray of shape (n_poses, n_dofs)
    bound : str
        The Euclidean metric that is bounded, and with it all that are never less.
    skeleton, steps
        As for `Metric.encoded`.

    Attributes
    ----------
    scale : float
        Unit of what follows.
    blocks : ndarray of shape (n_blocks * n_coordinates, lanes)
        Coordinates in blocks of lanes.
    norm : float
        Of the longest of them; infinite where the screen is of no use, as poses are beyond the range of float32.
    """

    def __init__(self, poses: np.ndarray, bound: str, skeleton: Skeleton | None, steps: Steps):
        self.bound, self.skeleton, self.steps = bound, skeleton, steps
        sample = np.linspace(0, len(poses) - 1, min(SAMPLE, len(poses))).astype(int)
        codes = METRICS[self.bound].encoded(poses[sample], skeleton, steps)
        self.scale = np.abs(codes).max() or 1.0
        codes /= self.scale
        self.mean = codes.mean(axis=0)
        codes -= self.mean
        self.axes = np.ascontiguousarray(np.linalg.eigh(codes.T @ codes)[1].T[: -N_AXES - 1 : -1])
        width = lanes(FLOAT32)
        self.n_coordinates = len(self.axes) + 1
        self.blocks = aligned(-(-len(poses) // width) * self.n_coordinates, width, FLOAT32)
        self.norm = 0.0
        for start in range(0, len(poses), PANEL):
            coordinates, norms = self._coordinates(poses[start : start + PANEL])
            self.part(start, start + len(coordinates))[:] = loops.in_lanes(coordinates)
            self.norm = max(self.norm, norms.max())

    def part(self, start: int, stop: int) -> np.ndarray:
        """The blocks of some of the poses; start is a multiple of the lanes."""
        width = self.blocks.shape[1]
        return self.blocks[start // width * self.n_coordinates : -(-stop // width) * self.n_coordinates]

    def of(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates of queries, and the slack of their bounds; infinite where they are out of range."""
        coordinates, norms = self._coordinates(poses)
        return coordinates, ROUNDING * (norms + self.norm)

    def _coordinates(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and their norms; nought and infinity where they are out of range."""
        with np.errstate(over="ignore"):
            codes = METRICS[self.bound].encoded(poses, self.skeleton, self.steps) / self.scale - self.mean
        out = np.abs(codes).max(axis=1) > IN_RANGE
        codes[out] = 0.0
        # Not by BLAS, whose threads would linger and take the processors from the search's.
        z = np.einsum("nc,ac->na", codes, self.axes)
        square = np.einsum("nc,nc->n", codes, codes)
        rest = np.sqrt(np.maximum(square - np.einsum("na,na->n", z, z), 0.0))
        return np.column_stack([z, rest]).astype(FLOAT32), np.where(out, np.inf, np.sqrt(square))
