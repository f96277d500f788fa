"""Repetitions of a movement in one recording."""

from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any

import numpy as np
from joblib import effective_n_jobs
from sklearn.utils import check_random_state

from skpose._compat.sklearn import Interval, validate_params
from skpose._validation.options import check_integer
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.metrics import Geodesic, Metric, Spatial
from skpose.metrics._shared import METRIC_CONSTRAINTS, resolve, warn_of_no_skeleton, warn_of_unconverged
from skpose.motions._deviations import STEPS, Deviations, deviations_of
from skpose.motions._frames import Frames
from skpose.motions._inputs import check_motion, check_motions
from skpose.motions._surrogates import p_value
from skpose.motions._template import Limits, explain, nothing
from skpose.skeleton import Motion, Skeleton

if TYPE_CHECKING:
    import pandas

MISSING = 0.1  # share of a repetition's frames, from which missing ones are said


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
    skeleton : Skeleton or None
        The skeleton on which the poses were compared; None where the motion was an array without one.
    times : ndarray of shape (n_frames,) or None
        Time of each frame of the recording, s; None where it was an array.

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
    skeleton: Skeleton | None
    times: np.ndarray | None

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

    def to_pandas(self, *, n_phases: int = 20) -> "pandas.DataFrame":
        """Return how far each joint of each repetition is from where the other repetitions have it, as a table.

        Sorted by `unusual`, the first row says which repetition was wrong, where, and when. Each repetition is compared
        with the median of the others, at equal phases of the movement: a wrong one does not spoil the reference of the
        rest while most are right, and tempo has no effect.

        Parameters
        ----------
        n_phases : int, default=20
            Phases into which the movement is divided, at most 200.

        Returns
        -------
        pandas.DataFrame of shape (n_rows, 11)
            One row for each repetition, joint and phase, in this order. A phase that a repetition lacks, as one that
            began before the recording, has no rows. The columns:

            - repetition: its index in `motions`,
            - joint: its name,
            - phase [%]: middle of the phase, from 0 to 100, the time in a typical repetition over its duration. 0 is
              the pose at which repetitions begin, ``motion[starts[k]]``: that from which on they are most like each
              other, or the end of a pause. It is no event, and another pose where the recording is cut elsewhere,
            - frame, time [s]: where this repetition is at that phase: the nearest frame of the recording, and its time,
              NaN where the motion was an array,
            - x [m], y [m], z [m]: from the median of the others to the mean position in this phase, in the axes of the
              root as it is turned, as `forward_kinematics` has positions,
            - deviation [m]: length of this vector,
            - spread [m]: how much the others vary there: median of their distances from the same reference, the mean of
              the phase and its two neighbours; NaN where there are fewer than three others,
            - unusual: deviation divided by the sum of spread and typical spread; NaN likewise.

            ``table.attrs`` states what it rests on: `n_repetitions`, `n_phases`, `reference`, `typical_spread`, the
            median of the spread, m, and `phase`, with a frame at which 0 % is.

        Raises
        ------
        ImportError
            If pandas is not installed.
        ValueError
            For fewer than two repetitions, for arrays without a skeleton, and for `n_phases` out of range.

        See Also
        --------
        align_motions : Two motions, with the joints in which they differ.
        mean_motion : The typical repetition.

        Notes
        -----
        `unusual` ranks; it is no probability. It assumes that more than half of the repetitions are done as meant. The
        largest number of a table is that of thousands of rows, so that it is far above 1 where nothing is wrong: 2.5 in
        the median of generated recordings of ten squats, and more than 4 in 4 of 100; of five squats more than 4 in 9
        of 100, of four in 31, and more than 6 in 4 (``benchmarks/wrong_repetition.py``). A knee that was 15° in for a
        fifth of one of ten squats was the first row in all 100 recordings, and in TWICE of 100 where the squats varied
        twice as much.

        A joint whose rotation is off moves all joints behind it: a knee that goes inward is seen at knee, ankle and
        toes. All positions are relative to the root, and in its axes: where the pelvis itself is off, the other joints
        are. What dynamic time warping explains by timing, such as a longer hold, is no deviation. The alignment is that
        of the sum of the distances of all joints, so that one limb does not choose it, and its ends are open: where a
        repetition is cut early or late, up to a third of the others or of itself has no counterpart.

        Positions are compared without the weights of the joints, which have an effect on the alignment alone. Each
        repetition is resampled to 200 steps. Time and memory O(n_repetitions²): 0.3 s for ten, some seconds for 50.

        References
        ----------
        V. G. Tusher, R. Tibshirani, G. Chu, "Significance analysis of microarrays applied to the ionizing radiation
        response", PNAS 98(9), 2001, :doi:`10.1073/pnas.091062498`: the constant in the denominator.

        Examples
        --------
        The strides of a generated walk, of which the third (2) has a bent left elbow for a while:

        >>> from dataclasses import replace
        >>> from skpose.motions import segment_repetitions
        >>> from skpose.datasets import make_gait
        >>> walk = make_gait(1, 1, activities=["walk"], duration=6, random_state=0)[0]
        >>> angles = walk.angles.copy()
        >>> angles[180:200, walk.skeleton.dof_names.index("left_forearm_rx")] -= 0.6
        >>> strides = segment_repetitions(replace(walk, angles=angles), random_state=0)
        >>> table = strides.to_pandas().sort_values("unusual", ascending=False)
        >>> print(table[["repetition", "joint", "time [s]", "deviation [m]"]].head(1).round(2).to_string(index=False))
         repetition     joint  time [s]  deviation [m]
                  2 left_hand      3.27           0.27
        """
        try:
            import pandas
        except ImportError:
            raise ImportError("to_pandas needs pandas: pip install 'skpose[pandas]'") from None

        skeleton, found, times = self._compare("to_pandas", n_phases)
        n, names = len(self), skeleton.joint_names

        def spread_out(values: Any, axes: tuple[int, ...]) -> np.ndarray:
            """Return values with axes among repetition, joint and phase as a column."""
            values = np.expand_dims(np.asarray(values), [axis for axis in range(3) if axis not in axes])
            return np.broadcast_to(values, (n, len(names), n_phases)).ravel()

        vectors = found.vectors.transpose(3, 0, 2, 1)
        table = pandas.DataFrame(
            {
                "repetition": spread_out(np.arange(n), (0,)),
                "joint": spread_out(np.array(names, dtype=object), (1,)),
                "phase [%]": spread_out(100.0 * found.phases, (2,)),
                "frame": spread_out(found.frames, (0, 2)),
                "time [s]": spread_out(times, (0, 2)),
                **dict(zip(("x [m]", "y [m]", "z [m]"), (one.ravel() for one in vectors), strict=True)),
                "deviation [m]": found.distances.transpose(0, 2, 1).ravel(),
                "spread [m]": found.spread.transpose(0, 2, 1).ravel(),
                "unusual": found.ratios.transpose(0, 2, 1).ravel(),
            }
        )
        table = table[spread_out(found.frames >= 0, (0, 2))].reset_index(drop=True)
        table.attrs.update(
            n_repetitions=n,
            n_phases=int(n_phases),
            reference="median of the other repetitions, after dynamic time warping",
            typical_spread=found.typical_spread,
            root="left out: a repetition that is wrong in where the whole body is, or leans, is not unusual",
            axes="those of the root",
            phase=self._describe_phase(),
        )
        return table

    def _describe_phase(self) -> str:
        """Return in words at which pose phases begin, and that it is no event."""
        time = "" if self.times is None else f", at {self.times[self.starts[0]]:.2f} s"
        return (
            f"0 % is where repetitions begin, such as frame {self.starts[0]} of the recording{time}, and 100 % where "
            "they end. It is the pose from which on the repetitions are most like each other, or the end of a pause, "
            "and no event such as a foot contact: of a recording that is cut elsewhere it may be another pose. Phases "
            "of two recordings are comparable where both begin with one pose"
        )

    def _compare(self, caller: str, n_phases: int) -> tuple[Skeleton, Deviations, np.ndarray]:
        """Return the skeleton, how far the repetitions are from each other, and their times (K, P) at each phase.

        Frames are whole ones of the recording, and -1 where a repetition lacks the phase.
        """
        check_integer(n_phases, 1, "n_phases")
        if n_phases > STEPS:
            raise ValueError(f"n_phases must be {STEPS} or less, into which repetitions are resampled, got {n_phases}")
        n = len(self)
        if n < 2:
            raise ValueError(
                f"{caller} compares repetitions with each other and needs at least two, got {n or 'none'}: "
                "segment_repetitions finds more with a lower min_fitness, or shorter ones with max_frames"
            )
        if self.skeleton is None:
            raise ValueError(
                f"{caller} needs a skeleton to place the joints, and these are repetitions of an array without one: "
                "pass skeleton= to segment_repetitions, or a Motion"
            )
        sequences = check_motions({"motions": self.motions}, self.skeleton)[0].sequences
        found = deviations_of([sequences.motion(k) for k in range(n)], self.skeleton, n_phases)
        is_there = ~np.isnan(found.frames)
        frames = self.starts[:, None] + np.rint(np.where(is_there, found.frames, 0.0)).astype(int)
        times = np.full(frames.shape, np.nan) if self.times is None else self.times[frames]
        frames = np.where(is_there, frames, -1)
        return self.skeleton, found._replace(frames=frames), times


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

    Any segment may be the *template*; its repetitions are the segments that align to it. It is chosen in five steps.

    *Still frames are left out*: those whose speed is below a fifth of that of fast frames (95th percentile). With D the
    median distance between the frames that are left, the similarity of two poses at distance d is
    :math:`1 - d / 0.9 D`.

    *Templates are rated.* The *path family* [1]_ of a template are paths through the matrix of similarities, each of
    which aligns the whole template to another segment, at between half and twice its tempo; the segments do not
    overlap, nor the template, and the sum of the similarities of all cells is the largest. With m frames in the
    template and n in all,

    .. math:: \sigma = \frac{\text{sum of similarities}}{\text{number of cells} + m},

    .. math:: \gamma = \frac{\text{frames of the segments}}{n}, \quad
              \text{fitness} = \frac{2 \sigma \gamma}{\sigma + \gamma}.

    *Templates are whole movements.* Two poses of one are at least 0.9 D apart: a pose that lasts is none. It *comes
    back*: its last pose, or the next one, is no farther from its first than 0.7 of the distance of the farthest, so
    that half of a movement is none, though the other halves repeat it. Segments are left out that come back by less
    than 0.85. None has a pause longer than half of the frames in which the template moves, unless fitness is 1.25 times
    as large with longer ones: movements that are held before they come back. These begin behind the longest pause.

    *Templates are one movement*, not several. Twice the movement is less fit than the movement, as more of it is the
    template itself, which does not count; but it is fitter where a repetition does not last whole frames. So another
    template is taken if it is at most 0.6 as long and as much more frequent, and if its fitness, relative to 1 − 1/k of
    k equal repetitions, is at least 0.9 of the other's.

    *Chance repeats, too*: of white noise the fitness of the best template is about that of a walk. So the motion is
    compared with *surrogates* [2]_, its own poses in another order: pieces of about an eighth of a movement, in random
    order. The p-value is the share of the surrogates that repeat as much, and above `alpha` nothing is found. What is
    compared is, for templates of each length, the fitness of the fittest, less its mean over the surrogates and divided
    by its standard deviation; the largest of these counts.

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
        First frames, last frames, distances, pauses, and the p-value; none where nothing repeats, and where no segment
        that aligns to the template comes back, though fitness and p-value pass.

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
        If the poses look like degrees, see `pose_distances`. If of a repetition more than a tenth of the frames are
        missing, see `Motion.frame_numbers`: it is compared as if none were.

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

    Templates are candidates of some lengths, each a seventh longer than the one before, and of `min_frames` and
    `max_frames`; they start a quarter of their length apart, and next to pauses. Start and length of the best are then
    refined. One movement is found, the one that explains most of the motion. Of a cycle, such as a stride, any phase
    may be the first, and where a recording begins or ends within a repetition, that may be one or not. So of a walk of
    two or three strides, the strides found may be a quarter shorter than true ones, and one more than there are.
    The root's movement is no part of it.

    Of repetitions of fewer than eight frames several may be taken as one, and so may two in a row of which one takes
    half as long as the template. Movements that are small among others that are large, of D above, are not found: cut
    the recording there. A joint that jumps is fast, and makes what is slower still: errors of the recording do, under
    every metric, and under "angle" angles and rotation vectors that go over from π to −π, see `Motion.unwrap`. Such
    repetitions are missed, or only their fast middle is found.

    The share `alpha` holds exactly where poses that are a piece apart are independent, and pieces are interchangeable.
    Movement is smoother: of single actions and of different actions one after the other, repetitions were found in
    fewer than that. It does not hold for smooth random movements of up to three degrees of freedom that stay near one
    pose: these pass the same poses in the same order again and again, and are mostly called repetitions. So is what
    oscillates irregularly: order is tested, not regularity. Of 120 random walks of three degrees of freedom, of 600 to
    3,000 frames, repetitions were found in 10, where 6 are expected. Two repetitions are enough where they are equal
    and all that moves: of 15 recordings of two repetitions of one action of HDM05, among standing, 9 were found. The
    surrogates take three to ten times as long as the search up to 300 frames, and twice as long for 2,000.

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
        warn_of_degrees(None, checked.skeleton, motion=poses)
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
    given, times = (motion, motion.times) if isinstance(motion, Motion) else (poses, None)
    repeated = [given[start:stop] for start, stop in zip(starts, stops, strict=True)]
    _warn_of_missing(repeated)
    return Repetitions(
        starts=starts,
        stops=stops,
        distances=found.distances,
        template=found.template,
        fitness=fitness,
        pvalue=pvalue,
        pauses=found.pauses,
        motions=repeated,
        skeleton=checked.skeleton,
        times=times,
    )


def _warn_of_missing(repetitions: Sequence[Motion | np.ndarray]) -> None:
    """Warn of repetitions in which many frames are missing, as they are compared as if none were."""
    for i, one in enumerate(repetitions):
        if isinstance(one, Motion):
            missing = int(np.ptp(one.frame_numbers)) + 1 - len(one)
            if missing > MISSING * len(one):
                warn(
                    f"repetition {i} lacks {missing} of the frames {one.frame_numbers[0]} to {one.frame_numbers[-1]}, "
                    "and is compared as if what is before and after them were one movement: cut the motion there"
                )


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
