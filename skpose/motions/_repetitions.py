"""Repetitions of a movement in one recording."""

from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

import numpy as np
from joblib import effective_n_jobs
from sklearn.utils import check_random_state

from skpose._utils.sklearn import Interval, validate_params
from skpose._utils.units import warn_of_degrees
from skpose._utils.warnings import warn
from skpose.metrics import Geodesic, Metric, Spatial
from skpose.metrics._matrix import warn_of_unconverged
from skpose.metrics._registry import METRIC_CONSTRAINTS, resolve, warn_of_no_skeleton
from skpose.motions._inputs import check_single_motions
from skpose.motions._surrogates import p_value
from skpose.motions._template import NOTHING, Frames, explain
from skpose.skeleton import Motion, Skeleton

MISSING = 0.1  # share of a repetition's frames; above it a warning says how many are missing


@dataclass(frozen=True, eq=False, repr=False)
class Repetitions:
    """The repetitions of a movement, from `segment_repetitions`.

    Attributes
    ----------
    starts, stops : ndarray of shape (n_repetitions,) of int
        Frames of each repetition, as in a slice: ``motion[start:stop]``. They are in order and do not overlap.
    distances : ndarray of shape (n_repetitions,)
        Mean distance between the poses of each repetition and the template, m (rad for "angle").
    template : int or None
        The repetition that the others resemble most, with distance zero; None if there are none.
    fitness : float
        How well the fittest template explains the motion, from 0 to 1, also if it is not significant: see
        `segment_repetitions`.
    pvalue : float
        Share of the surrogates that repeat as much as the motion, the motion included. 1.0 if nothing moves.
    motions : list of Motion, or of ndarray of shape (n_frames, n_dofs)
        The repetitions, as `mean_motion` takes them.
    skeleton : Skeleton or None
        The skeleton on which the poses were compared; None for an array without one.
    times : ndarray of shape (n_frames,) or None
        Time of each frame of the recording, s; None for an array.
    reason : str
        The reason if there are none.

    Examples
    --------
    >>> from skpose.motions import segment_repetitions
    >>> from skpose.datasets import make_gait
    >>> run = make_gait(1, 1, activities=["run"], random_state=0)[0]
    >>> segment_repetitions(run, random_state=0)
    Repetitions(4 of 43 to 45 frames, fitness 0.67, p = 0.01)
    """

    starts: np.ndarray
    stops: np.ndarray
    distances: np.ndarray
    template: int | None
    fitness: float
    pvalue: float
    motions: list
    skeleton: Skeleton | None
    times: np.ndarray | None
    reason: str = ""

    def __len__(self) -> int:
        return len(self.starts)

    def __repr__(self) -> str:
        lengths = self.stops - self.starts
        found = f"{len(self)} of {lengths.min()} to {lengths.max()} frames" if len(self) else "none"
        return f"Repetitions({found}, fitness {self.fitness:.2f}, p = {self.pvalue:.2g})"


@validate_params(
    METRIC_CONSTRAINTS
    | {
        "min_frames": [Interval(Integral, 1, None, closed="left"), None],
        "max_frames": [Interval(Integral, 1, None, closed="left"), None],
        "min_fitness": [Interval(Real, 0, 1, closed="both")],
        "alpha": [Interval(Real, 0, 1, closed="right")],
        "n_surrogates": [Interval(Integral, 1, None, closed="left")],
        "random_state": ["random_state"],
        "n_jobs": [None, Integral],
    },
    prefer_skip_nested_validation=True,
)
def segment_repetitions(
    motion: Any,
    *,
    skeleton: Skeleton | None = None,
    metric: str | Metric = "auto",
    min_frames: int | None = None,
    max_frames: int | None = None,
    min_fitness: float = 0.3,
    alpha: float = 0.05,
    n_surrogates: int = 99,
    random_state: int | np.random.RandomState | None = None,
    n_jobs: int | None = None,
) -> Repetitions:
    r"""Find where a movement repeats in a motion, from the distances between its poses.

    Any segment may be the *template*; its repetitions are the segments that align to it.

    *Still frames are left out*: their speed is below a fifth of the speed of fast frames (95th percentile). With D the
    median distance between the remaining frames, the similarity of two poses at distance d is :math:`1 - d / 0.9 D`.

    *Templates are rated.* The *path family* [1]_ of a template are paths through the matrix of similarities. Each
    aligns the whole template to another segment at between half and twice its tempo. The segments do not overlap each
    other or the template, and the sum of the similarities of all cells is the largest. With m frames in the template
    and n in all,

    .. math:: \sigma = \frac{\text{sum of similarities}}{\text{number of cells} + m},

    .. math:: \gamma = \frac{\text{frames of the segments}}{n}, \quad
              \text{fitness} = \frac{2 \sigma \gamma}{\sigma + \gamma}.

    *Templates are whole movements.* Two of their poses are at least 0.9 D apart, which excludes lasting poses. They
    *come back*: the last pose, or the next one, is at most 0.7 of the largest distance away from the first pose, which
    excludes half movements. Other segments must come back to 0.85. No repetition contains a pause longer than half of
    the moving frames of the template, unless fitness is 1.25 times as large with longer ones: movements that are held
    before they come back. These begin after the longest pause.

    *Templates are one movement*, not several. Another template is taken if it is at most 0.6 as long, as much more
    frequent, and if its fitness, relative to 1 − 1/k for k equal repetitions, is at least 0.9 of the other's.

    *Chance repeats, too*: the best template of white noise is about as fit as the best one of a walk. So the motion is
    compared with *surrogates* [2]_, its own poses in pieces of about an eighth of a movement in random order. The
    p-value is the share of surrogates that repeat as much; above `alpha` nothing is found. The statistic is the fitness
    of the fittest template of each length, minus its mean over the surrogates and divided by its standard deviation;
    the largest counts.

    With "spatial" and "geodesic", joints of two or three Euler angles are compared as rotations, see
    `Motion.to_rotvec`.

    Parameters
    ----------
    motion : Motion, or array-like of shape (n_frames, n_dofs)
        The motion: joint angles, and rotation vectors of ball joints, rad.
    skeleton : Skeleton, default=None
        The skeleton; None takes it from a `Motion`.
    metric : str or Metric, default="auto"
        The distance between poses, see `pose_distances`; "auto" is "spatial" with a skeleton, else "angle" with a
        warning.
    min_frames, max_frames : int, default=None
        Least and largest number of frames of the template. A template has at least 5 moving frames, and at most half of
        them all.
    min_fitness : float between 0 and 1, default=0.3
        Fitness below which nothing is found. k equal repetitions and nothing else have the fitness 1 − 1/k; people
        reach 0.4 to 0.7. Recordings in which little of the motion repeats need a lower value.
    alpha : float in (0, 1], default=0.05
        Largest p-value at which repetitions are found: the rate of false alarms. 1 finds repetitions in any case.
    n_surrogates : int, default=99
        Number of surrogates. The least p-value is 1 / (n_surrogates + 1).
    random_state : int, RandomState instance or None, default=None
        Source of the surrogates. Pass an int for the same p-value at every call.
    n_jobs : int, default=None
        Threads, as in scikit-learn.

    Returns
    -------
    Repetitions
        Starts, stops, distances and the p-value; without repetitions if nothing repeats.

    Raises
    ------
    TypeError
        If `motion` is a list of motions.
    ValueError
        If `min_frames` is above `max_frames`, or `n_surrogates` is too small for `alpha`.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.
    UserWarning
        If the poses look like degrees, see `pose_distances`, or if more than a tenth of the frames of a repetition are
        missing, see `Motion.frame_numbers`.

    See Also
    --------
    mean_motion : The typical repetition.
    find_motion : The matches of a given motion in long recordings.

    Notes
    -----
    One movement is found, the one that explains most of the motion. Any phase of a cycle may be the first, and if a
    recording begins or ends within a repetition, that one may be missing. The movement of the root is ignored.

    Movements that are small among larger ones are not found; cut the recording first. A joint that jumps, as after
    errors of the recording, makes slower movements still; see `Motion.unwrap` for "angle".

    The rate `alpha` is exact if poses a piece apart are independent. Movement is smoother, and is found in fewer cases.
    Smooth random movements of up to three degrees of freedom that stay near one pose are mostly called repetitions, as
    is what oscillates irregularly: order is tested, not regularity.

    Up to n = 2,000 frames all n² distances between poses are computed, in seconds and 0.13 GB. Longer motions take time
    in proportion to n, one to five milliseconds per frame; long templates are then exact to a sixteenth of their
    length.

    References
    ----------
    .. [1] M. Müller, N. Jiang, P. Grosche, "A robust fitness measure for capturing repetitions in music recordings with
       applications to audio thumbnailing", IEEE Transactions on Audio, Speech, and Language Processing 21(3), 2013,
       :doi:`10.1109/TASL.2012.2227732`.
    .. [2] J. Theiler, S. Eubank, A. Longtin, B. Galdrikian, J. D. Farmer, "Testing for nonlinearity in time series: the
       method of surrogate data", Physica D 58, 1992, :doi:`10.1016/0167-2789(92)90102-S`.

    Examples
    --------
    The strides of a generated walk:

    >>> from skpose.motions import segment_repetitions
    >>> from skpose.datasets import make_gait
    >>> walk = make_gait(1, 1, activities=["walk"], duration=6, random_state=0)[0]
    >>> strides = segment_repetitions(walk, random_state=0)
    >>> strides
    Repetitions(5 of 64 to 67 frames, fitness 0.67, p = 0.01)
    >>> (strides.starts / walk.frame_rate).round(1).tolist()
    [0.5, 1.6, 2.7, 3.8, 4.9]

    Noise repeats by chance alone:

    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> noise = np.random.default_rng(0).normal(size=(100, 3))
    >>> segment_repetitions(noise, skeleton=Skeleton.chain(3), random_state=0)
    Repetitions(none, fitness 0.57, p = 0.44)
    >>> segment_repetitions(noise, skeleton=Skeleton.chain(3), random_state=0).reason
    'the p-value is above 0.05: random orders of its parts repeat as much'
    """
    (checked,) = check_single_motions({"motion": motion}, skeleton)
    if min_frames is not None and max_frames is not None and min_frames > max_frames:
        raise ValueError(f"min_frames must be at most max_frames, got {min_frames} and {max_frames}")
    if alpha * (n_surrogates + 1) < 1.0 - 1e-9:
        least = int(np.ceil(1 / alpha - 1e-9)) - 1
        raise ValueError(f"n_surrogates must be at least {least} for alpha={alpha}, got {n_surrogates}")
    chosen = resolve(metric, checked.skeleton)
    warn_of_no_skeleton(metric, checked.skeleton)
    poses = checked.sequences.poses
    if checked.skeleton is not None:
        warn_of_degrees(None, checked.skeleton, motion=poses)
    limits, n_threads = (min_frames or 1, max_frames or np.inf), effective_n_jobs(n_jobs)
    frames = Frames(*_turn_euler(poses, chosen, checked.skeleton), n_jobs)
    best, fitness, pvalue, found = explain(frames, limits, n_threads), 0.0, 1.0, NOTHING
    reason = "no movement comes back to its first pose and repeats"
    if best is not None:
        fitness = best.fitness
        pvalue = p_value(frames, limits, n_surrogates, check_random_state(random_state), n_threads)
        found = best.repetitions()
        if fitness < min_fitness:
            found, reason = NOTHING, f"the fitness is below {min_fitness:g}: little of the recording repeats"
        elif pvalue > alpha:
            found, reason = NOTHING, f"the p-value is above {alpha:g}: random orders of its parts repeat as much"
    warn_of_unconverged(frames.unconverged, frames.n_pairs)
    starts, stops = found.segments.T
    given, times = (motion, motion.times) if isinstance(motion, Motion) else (poses, None)
    repeated = [given[start:stop] for start, stop in zip(starts, stops, strict=True)]
    for i, one in enumerate(repeated):
        missing = int(np.ptp(one.frame_numbers)) + 1 - len(one) if isinstance(one, Motion) else 0
        if missing > MISSING * len(one):
            warn(f"repetition {i} lacks {missing} frames of the recording, and is compared as if it were complete")
    return Repetitions(
        starts,
        stops,
        found.distances,
        found.template,
        fitness,
        pvalue,
        repeated,
        checked.skeleton,
        times,
        "" if len(starts) else reason,
    )


def _turn_euler(
    poses: np.ndarray, metric: Metric, skeleton: Skeleton | None
) -> tuple[np.ndarray, Metric, Skeleton | None]:
    """Convert joints of Euler angles to ball joints if the line between two poses matters.

    Files change from one triple of angles of a rotation to another, which is far along a line, but no movement.
    """
    if skeleton is None or not isinstance(metric, Spatial | Geodesic):
        return poses, metric, skeleton
    turned = Motion(skeleton, poses, frame_rate=1).to_rotvec()
    return turned.angles, metric, turned.skeleton
