"""Repetitions of a movement in one recording."""

from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

import numpy as np
from joblib import effective_n_jobs
from sklearn.utils import check_random_state

from skpose._compat.sklearn import Interval, validate_params
from skpose._validation.units import warn_of_degrees
from skpose.metrics import Geodesic, Metric, Spatial
from skpose.metrics._shared import METRIC_CONSTRAINTS, resolve, warn_of_no_skeleton, warn_of_unconverged
from skpose.motions._frames import Frames
from skpose.motions._inputs import check_motion
from skpose.motions._surrogates import p_value
from skpose.motions._template import Limits, explain, nothing
from skpose.skeleton import Motion, Skeleton


@dataclass(frozen=True, eq=False, repr=False)
class Repetitions:
    """The repetitions of a movement, as `segment_repetitions` finds them.

    Attributes
    ----------
    starts, stops : ndarray of shape (n_repetitions,) of int
        First frame of each repetition, and the one behind its last: ``motion[start:stop]``. They follow each other,
        and do not overlap.
    distances : ndarray of shape (n_repetitions,)
        Mean distance of the poses of each repetition from those of the template, m (rad for "angle").
    template : int or None
        The repetition that the others resemble most, of distance zero; None where there are none.
    fitness : float
        How well the fittest template explains the motion, from 0 to 1, also where it is not significant: see
        `segment_repetitions`.
    pvalue : float
        How often a motion in which nothing repeats would repeat as much by chance: the share of the surrogates that
        do, the motion counted among them. 1.0 where nothing moves.
    pauses : ndarray of shape (n_pauses, 2) of int
        Where the motion is still: first frame and the one behind the last of each pause. No repetition has a frame of
        one. What is shorter than a quarter of a repetition is a turn, and no pause.
    motions : list of Motion, or of ndarray of shape (n_frames, n_dofs)
        The repetitions themselves, as `mean_motion` takes them.

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
    pauses: np.ndarray
    motions: list

    def __len__(self) -> int:
        return len(self.starts)

    def __repr__(self) -> str:
        found = "none"
        if len(self):
            lengths = self.stops - self.starts
            found = f"{len(self)} of {lengths.min()} to {lengths.max()} frames"
        n_pauses = len(self.pauses)
        pauses = f", {n_pauses} pause{'s' * (n_pauses > 1)}" if n_pauses else ""
        return f"Repetitions({found}{pauses}, fitness {self.fitness:.2f}, p = {self.pvalue:.2g})"


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
    r"""Return where a movement repeats, from the distances between all poses of the motion.

    Any segment may be the *template*. Its *path family* [1]_ are paths through the matrix of similarities, each of
    which aligns the whole template to another segment, at between half and twice its tempo; the segments do not
    overlap, nor the template, and the sum of the similarities of all cells is the largest. With m frames in the
    template and n in all,

    .. math:: \sigma = \frac{\text{sum of similarities}}{\text{number of cells} + m},

    .. math:: \gamma = \frac{\text{frames of the segments}}{n}, \quad
              \text{fitness} = \frac{2 \sigma \gamma}{\sigma + \gamma}.

    The repetitions are the fittest template and its segments. A template *comes back*: its last pose, or the next one,
    is no farther from its first than 0.7 of the distance of the farthest, so that half of a movement is none, though
    the other halves repeat it; and segments are left out that come back by less than 0.85. Twice the movement is less
    fit than the movement, as more of it is the template itself, which does not count; where it is fitter, since a
    repetition does not last whole frames, a template that is at most 0.6 as long and as much more frequent is taken, if
    its fitness, relative to 1 − 1/k of k repetitions, is at least 0.9 of the other's.

    Chance repeats, too: of white noise the fitness of the best template is about that of a walk. So the motion is
    compared with *surrogates* [2]_, its own poses in another order: pieces of about an eighth of a movement, in random
    order. The p-value is the share of the surrogates that repeat as much, and above `alpha` nothing is found. What is
    compared is, for templates of each length, the fitness of the fittest, less its mean over the surrogates and divided
    by its standard deviation; the largest of these counts.

    Stillness is no repetition: frames whose speed is below a fifth of that of fast frames (95th percentile) are left
    out, and no repetition has a pause longer than half of the frames in which its template moves, unless fitness is
    1.25 times as large with longer ones: movements that are held before they come back. These begin behind the longest
    pause. With D the median distance between the frames that are left, the similarity of two poses at distance d is
    :math:`1 - d / 0.9 D`, and a template must have two poses that are 0.9 D apart: a pose that lasts is none.

    Under "spatial" and "geodesic" joints of two or three Euler angles are compared as rotations, as after
    `Motion.to_rotvec`: the same pose in other angles, to which files go over, would be far away.

    Parameters
    ----------
    motion : Motion, or array-like of shape (n_frames, n_dofs)
        The motion: joint angles, and rotation vectors of ball joints, rad.
    skeleton : Skeleton, default=None
        The skeleton; None is that of a `Motion`.
    metric : str or Metric, default="auto"
        The distance between poses, see `pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a
        warning.
    min_frames, max_frames : int, default=None
        Least and largest number of frames of the template. None is no limit but this: it is at least 5 frames that
        move, and at most half of these.
    min_fitness : float between 0 and 1, default=0.3
        Fitness below which nothing is found. Where k equal repetitions are all of the motion, the fitness is 1 − 1/k;
        people differ, and reach 0.4 to 0.7. Recordings in which little of the motion repeats need a lower one.
    alpha : float in (0, 1], default=0.05
        Largest p-value at which something is found: the share of motions without repetitions in which it is. 1 finds
        repetitions in any case.
    n_surrogates : int, default=99
        Surrogates. The least p-value is 1 / (n_surrogates + 1).
    random_state : int, RandomState instance or None, default=None
        Source of the surrogates. Pass an int for the same p-value at every call.
    n_jobs : int, default=None
        Threads, as in scikit-learn.

    Returns
    -------
    Repetitions
        First frames, last frames, distances, pauses, and the p-value; none where nothing repeats.

    Raises
    ------
    TypeError
        For several motions in the place of one.
    ValueError
        For poses that `pose_distances` refuses, a `min_frames` above `max_frames`, and fewer surrogates than `alpha`
        needs.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.
    UserWarning
        If the poses look like degrees, see `pose_distances`.

    See Also
    --------
    mean_motion : The typical repetition.
    find_motion : The places of a given motion in long recordings.

    Notes
    -----
    Up to n = 2,000 frames that takes O(n²) distances between poses, and some hundred times n² steps of the recursion,
    of some nanoseconds each: below a second for 500 frames that move, some seconds for 2,000; memory 0.13 GB. Longer
    motions take time in proportion to n, one to five milliseconds a frame, and 1 kB more for each: templates of up to
    256 frames are looked for in sections of 2,000 or fewer, longer or rarer ones in sections of every second frame,
    every fourth, and so on. Some of each section and size are compared with the whole motion. With m frames in the
    template, starts and stops are exact to k frames, :math:`k = \lceil \sqrt{nm} / 2000 \rceil`, and to m/16 or better.

    Templates are candidates of some lengths, each a seventh longer than the one before, that start a quarter of their
    length apart; start and length of the best three are then refined. One movement is found, the one that explains most
    of the motion. Of a cycle, such as a stride, any phase may be the first; where a recording begins or ends within a
    repetition, that may be one or not. The root's movement is no part of it. Of repetitions of fewer than eight frames
    several may be taken as one, and movements that are small among others that are large, of D above, are not found:
    cut the recording there.

    The share `alpha` holds exactly where poses that are a piece apart are independent, and pieces are interchangeable.
    Movement is smoother: of single actions and of different actions one after the other, repetitions were found in
    fewer than that. It does not hold for smooth random movements of up to three degrees of freedom that stay near one
    pose: these pass the same poses in the same order again and again, and are mostly called repetitions. So is what
    oscillates irregularly: order is tested, not regularity. Two repetitions are enough where they are all of the
    motion. The surrogates take three to ten times as long as the search up to 300 frames, and twice as long for 2,000.

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
    """
    checked = check_motion(motion, skeleton, "motion")
    if min_frames is not None and max_frames is not None and min_frames > max_frames:
        raise ValueError(f"min_frames must be no more than max_frames, got {min_frames} and {max_frames}")
    if alpha * (n_surrogates + 1) < 1.0 - 1e-9:
        raise ValueError(
            f"p-values of n_surrogates={n_surrogates} are at least {1 / (n_surrogates + 1):.3g}, so that nothing is "
            f"found at alpha={alpha}: use n_surrogates={int(np.ceil(1 / alpha - 1e-9)) - 1} or more, or a larger alpha"
        )
    chosen = resolve(metric, checked.skeleton)
    warn_of_no_skeleton(metric, checked.skeleton)
    poses = checked.sequences.poses
    if checked.skeleton is not None:
        warn_of_degrees(motion=poses)
    limits, n_threads = Limits(min_frames or 1, max_frames or np.inf), effective_n_jobs(n_jobs)
    frames = Frames(*_turn_euler(poses, chosen, checked.skeleton), n_jobs)
    best, fitness, pvalue, found = explain(frames, limits, n_threads), 0.0, 1.0, nothing(frames)
    if best is not None:
        fitness = best.fitness
        pvalue = p_value(frames, limits, n_surrogates, check_random_state(random_state), n_threads)
        if fitness >= min_fitness and pvalue <= alpha:
            found = best.repetitions()
    warn_of_unconverged(frames.unconverged, frames.n_pairs)
    starts, stops = found.segments.T
    given = motion if isinstance(motion, Motion) else poses
    repeated = [given[start:stop] for start, stop in zip(starts, stops, strict=True)]
    return Repetitions(starts, stops, found.distances, found.template, fitness, pvalue, found.pauses, repeated)


def _turn_euler(
    poses: np.ndarray, metric: Metric, skeleton: Skeleton | None
) -> tuple[np.ndarray, Metric, Skeleton | None]:
    """Turn joints of Euler angles into ball joints where the line between two poses counts.

    Files go over from one triple of a rotation to another one, which is no movement, but far away along a line.
    """
    if skeleton is None or not isinstance(metric, Spatial | Geodesic):
        return poses, metric, skeleton
    turned = Motion(skeleton, poses, frame_rate=1).to_rotvec()
    return turned.angles, metric, turned.skeleton
