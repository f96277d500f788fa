"""Movements in a stream of poses, frame by frame: which one is going on, how far it is, and what has ended."""

from collections.abc import Hashable, Sequence
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from skpose._compat.sklearn import Interval, validate_params
from skpose._compiled.warping.stream import best_prefixes
from skpose._typing import ArrayLike
from skpose._validation.poses import check_is_array, check_pose, check_poses
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.metrics import Metric
from skpose.metrics._shared import (
    DistanceMatrix,
    MotionMetric,
    Tile,
    resolve,
    warn_of_no_skeleton,
    warn_of_unconverged,
)
from skpose.motions._distances import COMPARED_CONSTRAINTS
from skpose.motions._inputs import check_motion, check_motions, rates_differ
from skpose.motions._stream_rows import Rows, TemplateWindows
from skpose.motions._windows import Window, choose_windows
from skpose.skeleton import Motion, Skeleton

N_PHASES = 100  # at which limits are learnt
PHASES = np.arange(1, N_PHASES + 1) / N_PHASES
TINY = 1e-12  # by which rounding may move a phase
SHOWN = 5  # templates that a warning names


class StreamMatch(NamedTuple):
    """A movement that has ended, as `MotionStream` found it.

    Attributes
    ----------
    template : int
        Index of the template.
    label : hashable
        Its label; the index where there are no labels.
    start, stop : int
        Frames of the stream, counted from zero; `stop` is behind the last one, as in a slice.
    distance : float
        The least sum of distances between frames, divided by the frames of the template, m, or rad for "angle".

    Examples
    --------
    >>> from skpose.motions import StreamMatch
    >>> StreamMatch(template=0, label="wave", start=120, stop=180, distance=0.2)
    StreamMatch(template=0, label='wave', start=120, stop=180, distance=0.2)
    """

    template: int
    label: Hashable
    start: int
    stop: int
    distance: float


class StreamState(NamedTuple):
    """State of a `MotionStream` after a frame.

    Attributes
    ----------
    frame : int
        Number of the frame, counted from zero.
    label : hashable or None
        The movement that is going on: the label of `template`; None where `sureness` is below `min_sureness`, or 0.
    template : int or None
        The template with the least ratio; None where nothing is going on.
    sureness : float
        Of the template with the least ratio: from 0, where another movement fits as well or none does, to 1, that
        template itself; see `MotionStream`. It is no probability.
    progress : ndarray of shape (n_templates,)
        How far each template is: the share of its frames in the prefix with the least ratio; 0 where that is above 1.
    ratios : ndarray of shape (n_templates,)
        The least ratio of the distance of a prefix that ends now and the largest that is taken for the same movement;
        infinity where no prefix counts.
    distances : ndarray of shape (n_templates,)
        Distance of the whole template from the window that ends now, m, or rad for "angle".
    starts : ndarray of shape (n_templates,) of int
        First frame of that window.
    matches : list of StreamMatch
        What has ended and is known for good since the state before, in the order in which it became known.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.motions import MotionStream
    >>> wave = np.sin(np.linspace(0, 6, 30))[:, None]
    >>> state = MotionStream([wave], skeleton=Skeleton.chain(1), max_distance=0.1).push(wave[:15])
    >>> state.label, state.sureness, state.progress
    (0, 1.0, array([0.5]))
    """

    frame: int
    label: Any
    template: int | None
    sureness: float
    progress: np.ndarray
    ratios: np.ndarray
    distances: np.ndarray
    starts: np.ndarray
    matches: list[StreamMatch]


class MotionStream:
    r"""Recognise movements in a stream of poses, while they go on.

    Each frame that is pushed continues the open-begin dynamic time warping of all templates by one column: S(i, t) is
    the least sum of distances along a path that takes the first i frames of a template, and ends at the frame t of the
    stream [1]_. The sums of the whole template are those of `find_motion`. Only the last column is kept, so that memory
    does not grow with the stream.

    **Matches.** A window that ends at a frame is within the limit if its distance, S over the frames n of the template,
    is no more than `max_distances`. Matches are the windows that `find_motion` chooses among them: the best one, then
    the best of those that overlap no more than half with it, and so on. Each is returned once, at the first frame after
    which nothing that comes can change it. All that `push` has returned and `finish` returns are, for each template,
    what ``find_motion(template, [stream], k=n_frames)`` finds with distances up to the limit.

    **What is going on.** The ratio of a template is the least of

    .. math:: \frac{S(i, t)}{i\, r_i}

    over its prefixes i, where :math:`r_i` is the largest distance that is taken for the same movement. It is
    `max_distance`, if that is given. Else it is learnt by leaving each template out: it is pushed from its first to its
    last frame, and for each share of the movement the least distance from the prefixes of the other templates of its
    label is noted, of other `groups` if these are given. :math:`r_i` is the largest of these, that of the template that
    is farthest from all others. What has the least ratio is going on, if that is at most 1. A prefix does not count
    where a person who stands still would pass for it: where the mean distance of its frames from some frame of the
    template is within :math:`r_i`. Nor does a path at more than twice the tempo of the template, or less than half, nor
    what is left over from a match, a path that overlaps the last one by more than half.

    **How sure.** With q the least ratio and q′ the least one of another label,

    .. math:: \text{sureness} = 1 - q / \min(1, q'),

    and 0 where that is negative. It states how far the best label is ahead of the second, or of the limit, in units of
    what its own repetitions differ. Below `min_sureness` no label is given. It is no probability, and assumes that

    - the templates of a label are repetitions of one movement, which differ as much as those in the stream. If so, one
      in m + 1 new ones is farther from the nearest of m templates than they are among each other, and is missed;
    - people go through a movement in its order. What passes through similar poses is similar.

    Parameters
    ----------
    templates : list of array-like or of Motion, MotionDataset, or array of shape (n_templates, n_frames, n_dofs)
        The movements, each from its beginning to its end, of shape (n_frames, n_dofs), as for `motion_distances`. All
        have one frame rate.
    labels : sequence of hashables of length n_templates, default=None
        What each template shows, such as ``dataset.actions``. None is a label of its own for each, its index.
    groups : sequence of hashables of length n_templates, default=None
        Whom each template shows, such as ``dataset.subjects``: limits are then learnt between people, for a person of
        whom there is no template. None is a group of its own for each.
    skeleton : Skeleton, default=None
        As for `motion_distances`: that of the stream, too.
    metric : str or Metric, default="auto"
        The distance between poses, see `pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a
        warning. "velocity" and "centered" need frames that are still to come, and are refused.
    max_distance : float, default=None
        The largest distance of what is taken for a template, m, or rad for "angle". None learns it from the templates
        of the same label, of which there must be two or more.
    min_sureness : float, default=0.1
        The least sureness at which a movement is going on, less than 1. See the notes for what it is worth.

    Attributes
    ----------
    skeleton : Skeleton or None
        The skeleton in use.
    metric : Metric
        The distance in use.
    frame_rate : float or None
        Frame rate of the templates, Hz, which the stream must have; None for arrays.
    labels : list
        The label of each template.
    max_distances : ndarray of shape (n_templates,)
        The largest distance of a match, by template.
    n_frames : int
        Number of the frames that were pushed since the stream began.

    Raises
    ------
    TypeError
        For one motion in the place of several, and for Motions and arrays together.
    ValueError
        For poses that `pose_distances` refuses, templates of different frame rates, skeletons that are not comparable;
        without `max_distance` for a label with a single template, of a single group, or with equal ones.

    Warns
    -----
    UserWarning
        If no prefix of a template counts, as it moves less than its repetitions differ: it may match, but is never
        going on. Also if the poses look like degrees.
    ConvergenceWarning
        If geodesics did not converge.

    See Also
    --------
    find_motion : The same search in recordings.
    segment_repetitions : Repetitions of a movement that is not known.

    Notes
    -----
    Time O(frames of all templates) distances a frame: 50 templates of two seconds at 30 Hz take 2.3 ms under "spatial",
    and less than 1 ms under "angle", "position" and "rotation"; at 60 Hz 4 and 1 ms (``benchmarks/stream.py``).
    "geodesic" takes far longer. Learning takes a distance for each pair of frames of templates of one label.

    Kept are: one column, a sum and a beginning for each frame of the templates; for each template its last match, and
    the windows within the limit that are undecided. A window is undecided while a path of the last column, with a
    smaller sum, overlaps it by more than half, or a better window that is undecided. Such paths are no longer than the
    limit over the least distance: a stream that repeats one pose of a template, to the last bit, keeps a window a frame
    until it moves.

    Distances are the same as those of `find_motion` to the last bit, but under "spatial" to 1e-12, as the curve is
    measured from its other end. Where two windows differ by no more than that, either may be chosen.

    Of HDM05, at 30 Hz, each person recognised by templates of the two others of every second action, "position": of the
    frames in the middle third of a movement 34 % have the right label at a sureness of 0.1 or more, and 0.2 % a wrong
    one; at 0.2 or more 20 and 0 %. Of frames of actions without templates 2.2 and 0.5 % have a label, of somebody who
    has been standing for a second 1.0 and 0.0 %, of noise none. The default was chosen by this table. A label is right
    in 36 % of the frames of sureness 0 to 0.1, in 64 % of those up to 0.2, in 83 % up to 0.4, in 97 % above.

    Time warps freely: somebody who stops in the middle of a movement is in the middle of it, for as long as it took to
    come there. A lost frame may be left out.

    References
    ----------
    .. [1] P. Tormene, T. Giorgino, S. Quaglini, M. Stefanelli, "Matching incomplete time series with dynamic time
       warping: an algorithm and an application to post-stroke rehabilitation", Artificial Intelligence in Medicine
       45(1), 2009, :doi:`10.1016/j.artmed.2008.11.007`: prefixes.
    .. [2] Y. Sakurai, C. Faloutsos, M. Yamamuro, "Stream monitoring under the time warping distance", ICDE 2007,
       :doi:`10.1109/ICDE.2007.368963`: one column, and matches that are returned when none to come can be better.

    Examples
    --------
    A wave and a lift of the arm, each twice; then somebody stands, waves, and stands again:

    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.motions import MotionStream
    >>> wave, lift = np.sin(np.linspace(0, 6, 30))[:, None], np.linspace(0, 2, 30)[:, None]
    >>> templates, labels = [wave, 0.8 * wave, lift, 0.8 * lift], ["wave", "wave", "lift", "lift"]
    >>> stream = MotionStream(templates, labels=labels, skeleton=Skeleton.chain(1), metric="position")
    >>> matches = []
    >>> for frame, pose in enumerate(np.concatenate([np.zeros((20, 1)), 0.9 * wave, np.zeros((20, 1))])):
    ...     state = stream.push(pose)
    ...     matches += state.matches
    ...     if frame % 12 == 11:
    ...         print(frame, state.label, round(state.sureness, 2), state.progress.max().round(2))
    11 None 0.0 0.0
    23 wave 0.38 0.13
    35 wave 0.41 0.53
    47 wave 0.44 0.97
    59 None 0.0 0.0
    >>> [(match.label, match.template, match.start, match.stop) for match in matches]
    [('wave', 0, 20, 50), ('wave', 1, 20, 50)]
    """

    @validate_params(
        COMPARED_CONSTRAINTS
        | {
            "max_distance": [Interval(Real, 0, None, closed="neither"), None],
            "min_sureness": [Interval(Real, 0, 1, closed="left")],
        },
        prefer_skip_nested_validation=True,
    )
    def __init__(
        self,
        templates: Any,
        *,
        labels: Sequence[Hashable] | None = None,
        groups: Sequence[Hashable] | None = None,
        skeleton: Skeleton | None = None,
        metric: str | Metric = "auto",
        max_distance: float | None = None,
        min_sureness: float = 0.1,
    ):
        (checked,) = check_motions({"templates": templates}, skeleton)
        self.metric = resolve(metric, checked.skeleton, of_motions=True)
        if isinstance(self.metric, MotionMetric):
            raise ValueError(
                f"the metric {self.metric.label!r} compares a frame by what comes before and after it, and of a stream "
                'the frames after it are not known yet: take "position" or another distance between poses'
            )
        if checked.skeleton is not None:
            warn_of_degrees(None, checked.skeleton, templates=checked.sequences.poses)
        warn_of_no_skeleton(metric, checked.skeleton)
        self.skeleton, self.frame_rate = checked.skeleton, checked.frame_rate
        self._templates = checked.sequences.in_float64()
        self.labels: list[Hashable] = (
            [*range(len(self))] if labels is None else _check_names(labels, len(self), "labels")
        )
        self._rows = Rows(self._templates, self.metric, self.skeleton)
        people: list[Hashable] = [*range(len(self))] if groups is None else _check_names(groups, len(self), "groups")
        limits = self._learn_limits(people) if max_distance is None else max_distance * self._rows.counts
        self.max_distances = (limits / self._rows.counts)[self._rows.last]
        self._limits = self._count_prefixes(limits)
        warn_of_unconverged(self._rows.unconverged, self._rows.n_measured)
        self.min_sureness = float(min_sureness)
        self._begin()

    def __len__(self) -> int:
        return self._templates.n_motions

    def __repr__(self) -> str:
        rate = "" if self.frame_rate is None else f" at {self.frame_rate:g} Hz"
        n_labels = len(dict.fromkeys(self.labels))
        return (
            f"MotionStream({len(self)} templates, {n_labels} label{'s' * (n_labels > 1)}, {len(self._templates.poses)} "
            f"frames{rate}, metric={self.metric.label!r}, {self.n_frames:,} pushed)"
        )

    def push(self, pose: ArrayLike | Motion) -> StreamState:
        """Take the next frame of the stream, or the next few.

        Parameters
        ----------
        pose : array-like of shape (n_dofs,) or (n_frames, n_dofs), or Motion
            One pose, or several in their order: joint angles, and rotation vectors of ball joints, rad. An array has no
            frame rate, and is taken to be at that of the templates.

        Returns
        -------
        StreamState
            The state after the last of the frames, with the matches of all of them. It is the same, to the last bit,
            whether frames come one by one or together.

        Raises
        ------
        TypeError
            For several motions.
        ValueError
            For a pose of another width, of NaN or infinity, as of a lost frame, and for a Motion of another frame rate
            or a skeleton that is not comparable. The stream is then as it was.

        Warns
        -----
        ConvergenceWarning
            If geodesics did not converge.
        UserWarning
            If the poses look like degrees.
        """
        poses = self._check_frames(pose)
        if self.skeleton is not None:
            warn_of_degrees(None, self.skeleton, pose=poses)
        self._rows.forget_counts()
        matches: list[StreamMatch] = []
        for code in self._rows.encode(poses):
            self._rows.advance(code, self._column, self.n_frames)
            self.n_frames += 1
            self._update_windows(matches)
        warn_of_unconverged(self._rows.unconverged, self._rows.n_measured)
        return self._state(matches)

    def finish(self) -> list[StreamMatch]:
        """End the stream, and begin a new one.

        Returns
        -------
        list of StreamMatch
            The matches that were not returned yet, as later frames might have changed them, by template and distance.
            The next frame that is pushed is frame zero of a new stream.
        """
        matches = []
        for template, windows in enumerate(self._windows):
            matches += [self._match(template, w) for w in choose_windows(windows.list_undecided(), -1)]
        self._begin()
        return matches

    def _begin(self) -> None:
        self.n_frames = 0
        self._column = self._rows.first_column()
        self._windows = [TemplateWindows() for _ in range(len(self))]
        self._last = np.zeros((len(self), 2), np.int64)

    def _check_frames(self, pose: Any) -> np.ndarray:
        """Return what is pushed as an array (n_frames, n_dofs)."""
        if isinstance(pose, Motion):
            here, there = pose.frame_rate, self.frame_rate
            if there is not None and rates_differ(here, there):
                raise ValueError(
                    f"pose has {here:g} Hz and the templates have {there:g} Hz, and the distance counts frames: pass "
                    f"pose.resample({there:g})"
                )
            poses = check_motion(pose, self.skeleton, "pose").sequences.poses
        else:
            check_is_array(pose, "pose")
            self._check_finite(pose)
            if not _is_row(pose):
                poses = check_poses(pose, self.skeleton, "pose")
            elif self.skeleton is None:
                poses = check_poses(np.asarray(pose)[np.newaxis], None, "pose")
            else:
                poses = check_pose(pose, self.skeleton, "pose")[np.newaxis]
        if poses.shape[1] != self._templates.poses.shape[1]:
            raise ValueError(
                f"pose has {poses.shape[1]} columns and the templates have {self._templates.poses.shape[1]}; poses of "
                "one skeleton have equally many"
            )
        return poses

    def _check_finite(self, pose: Any) -> None:
        """Refuse lost frames, by their number; what is no array of numbers has errors of its own."""
        try:
            values = np.asarray(pose, dtype=np.float64)
        except (TypeError, ValueError):
            return
        if values.ndim not in (1, 2):
            return
        lost = np.flatnonzero(~np.isfinite(np.atleast_2d(values)).all(axis=1))
        if len(lost):
            raise ValueError(
                f"pose is NaN or infinite in {len(lost)} of {len(np.atleast_2d(values))} frames, first in frame "
                f"{self.n_frames + lost[0]} of the stream: leave a lost frame out, as time warps, or push the pose "
                "before it again. The stream is as it was before this call"
            )

    def _learn_limits(self, groups: list[Hashable]) -> np.ndarray:
        """Return, for each prefix, the largest sum that is taken for its label."""
        limits = np.zeros(len(self._templates.poses))
        for label in dict.fromkeys(self.labels):
            chosen = np.array([i for i, other in enumerate(self.labels) if other == label])
            if len({groups[i] for i in chosen}) == 1:
                whose = "one template" if len(chosen) == 1 else f"templates of one group, {groups[chosen[0]]!r}, alone"
                raise ValueError(
                    f"the label {label!r} has {whose}, so that nothing shows how much its repetitions differ: pass "
                    "labels= with two templates or more of each label, of two groups if there are groups, or "
                    "max_distance="
                )
            some = Rows(self._templates.take(chosen), self.metric, self.skeleton)
            nearest = np.full((len(chosen), N_PHASES), np.inf)
            for k, performance in enumerate(chosen):
                distances = some.least_sums(self._templates.motion(performance)) / some.counts
                for other, template in enumerate(chosen):
                    if groups[template] != groups[performance]:
                        rows = some.starts[other] + np.ceil(PHASES * some.lengths[other]).astype(int) - 1
                        np.minimum(nearest[k], distances[rows], out=nearest[k])
            largest = nearest.max(axis=0)
            if largest[-1] == 0.0:
                raise ValueError(
                    f"the templates of the label {label!r} are equal, so that nothing shows how much repetitions "
                    "differ: leave copies out, or pass max_distance="
                )
            for template in chosen:
                rows = np.arange(self._rows.starts[template], self._rows.starts[template + 1])
                progress = self._rows.counts[rows] / len(rows)
                limits[rows] = largest[np.searchsorted(PHASES, progress - TINY)] * self._rows.counts[rows]
            self._rows.take_counts(some)
        return limits

    def _count_prefixes(self, limits: np.ndarray) -> np.ndarray:
        """Return the limits of the prefixes that count, and zero for those for which a still pose would pass."""
        limits, still = limits.copy(), []
        for template in range(len(self)):
            poses = self._templates.motion(template)
            n = len(poses)
            distances, unconverged = DistanceMatrix(poses, None, self.metric, self.skeleton).distances(Tile(0, n, 0, n))
            self._rows.unconverged.append(unconverged)
            self._rows.n_measured += n * (n - 1) // 2
            of_template = limits[self._rows.starts[template] : self._rows.starts[template + 1]]
            of_template[np.cumsum(distances, axis=0).min(axis=1) <= of_template] = 0.0
            if not of_template.any():
                still.append(template)
        if still:
            names = ", ".join(f"templates[{i}]" for i in still[:SHOWN]) + ", …" * (len(still) > SHOWN)
            warn(
                f"{len(still)} of {len(self)} templates move no more than what is taken for the same movement, so that "
                f"a person who stands still would pass for them: {names}. They may match, but are never going on; pass "
                "a smaller max_distance=, or templates that resemble each other more"
            )
        return limits

    def _update_windows(self, matches: list[StreamMatch]) -> None:
        """Take the windows that end at the last frame, and append the matches that are known for good."""
        ends = self._column.sums[self._rows.last]
        within = ends / self._rows.lengths <= self.max_distances
        for template, windows in enumerate(self._windows):
            first, end = self._rows.starts[template], self._rows.starts[template + 1]
            if within[template]:
                windows.insert(ends[template], self._column.starts[end - 1], self.n_frames)
            if windows.n_pending:
                found = windows.decide(self._column, first, end, self.n_frames - 1)
                matches += [self._match(template, window) for window in found]
                self._last[template] = windows.last

    def _match(self, template: int, window: Window) -> StreamMatch:
        distance = window.sum / int(self._rows.lengths[template])
        return StreamMatch(template, self.labels[template], window.start, window.stop, distance)

    def _state(self, matches: list[StreamMatch]) -> StreamState:
        ratios, prefixes = np.empty(len(self)), np.empty(len(self), np.int64)
        best_prefixes(self._column, self._rows.starts, self._limits, self._last, self.n_frames - 1, ratios, prefixes)
        template = int(ratios.argmin())
        label, sureness = self.labels[template], 0.0
        rival = min([1.0, *(q for q, other in zip(ratios.tolist(), self.labels, strict=True) if other != label)])
        if ratios[template] < rival:
            sureness = float(1.0 - ratios[template] / rival)
        is_going_on = sureness > 0.0 and sureness >= self.min_sureness
        last = self._rows.last
        return StreamState(
            self.n_frames - 1,
            label if is_going_on else None,
            template if is_going_on else None,
            sureness,
            np.where(ratios <= 1.0, prefixes / self._rows.lengths, 0.0),
            ratios,
            self._column.sums[last] / self._rows.lengths,
            self._column.starts[last].copy(),
            matches,
        )


def _is_row(pose: Any) -> bool:
    """Return whether an array, a list or a Series has one axis."""
    try:
        return np.ndim(pose) == 1
    except ValueError:  # rows of different lengths, which have an error of their own
        return False


def _check_names(names: Sequence[Hashable], n_templates: int, argument: str) -> list[Hashable]:
    """Return a label or a group for each template; numbers of numpy are Python's."""
    if isinstance(names, str) or not hasattr(names, "__len__"):
        raise TypeError(f"{argument} must be a sequence, with one of the {argument} for each template, got {names!r}")
    if len(names) != n_templates:
        raise ValueError(f"{argument} has length {len(names)}, for {n_templates} templates: pass one for each")
    listed = names.tolist() if isinstance(names, np.ndarray) else list(names)
    for i, name in enumerate(listed):
        if name is None or not isinstance(name, Hashable) or name != name:
            raise TypeError(f"{argument}[{i}] is {name!r}: pass a name or a number, and leave out what has none")
    return listed
