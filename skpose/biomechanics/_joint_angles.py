"""Clinical joint angles: flexion, adduction, rotation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, overload

import numpy as np

from skpose._utils.typing import DataFrame
from skpose._utils.validation import check_kind, near_names
from skpose._utils.warnings import warn
from skpose.biomechanics._gait_events import GaitEvents, gait_events
from skpose.biomechanics._measure import find_zero, measure
from skpose.biomechanics._segments import find_person, find_segments
from skpose.datasets import MotionDataset
from skpose.kinematics._anatomy import SIDES
from skpose.motions import Repetitions
from skpose.motions._phases import PHASES, over_phases
from skpose.skeleton import Motion


@dataclass(frozen=True, eq=False, repr=False)
class JointAngles:
    """Joint angles in time, with their zero and the reasons for missing values.

    Attributes
    ----------
    names : tuple of str
        Names of the angles, such as ``"knee_flexion_left"``.
    degrees : ndarray of shape (n_frames, n_angles)
        The angles, degrees; NaN where the motion does not show them.
    times : ndarray of shape (n_frames,)
        Time of each frame, s.
    zero : str
        The pose in which joints are at zero.
    missing : dict of str to str
        The reason for each angle that is NaN in some frames.
    forward : ndarray of shape (3,) or None
        The direction in the world relative to which ``pelvis_rotation`` is measured.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.biomechanics import joint_angles
    >>> from skpose.datasets import humanoid
    >>> angles = joint_angles(Motion(humanoid(), np.zeros((5, 42)), frame_rate=30))
    >>> angles
    JointAngles(5 frames, 49 angles, 10 with NaN, zero: rest pose)
    >>> angles.missing["wrist_flexion_left"]
    'no thumb next to the line of the hand shows where the palm is'
    """

    names: tuple[str, ...]
    degrees: np.ndarray
    times: np.ndarray
    zero: str
    missing: dict[str, str]
    forward: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.degrees)

    def __getitem__(self, name: str) -> np.ndarray:
        """One angle in time, degrees."""
        if name not in self.names:
            raise KeyError(f"there is no angle {name!r}: {near_names(self.names, str(name), 'see names')}")
        return self.degrees[:, self.names.index(name)]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.degrees, dtype) if copy else np.asarray(self.degrees, dtype)

    def __repr__(self) -> str:
        missing = f", {len(self.missing)} with NaN" if self.missing else ""
        return f"JointAngles({len(self)} frames, {len(self.names)} angles{missing}, zero: {self.zero})"

    def to_pandas(self) -> DataFrame:
        """Convert the angles to a pandas DataFrame, one column for each angle and one row for each frame.

        Returns
        -------
        pandas.DataFrame of shape (n_frames, n_angles)
            Angles by their names and unit, such as "knee_flexion_left [deg]"; the index is the time of each frame, s.
            ``attrs`` has zero and missing.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas

        columns = [f"{name} [deg]" for name in self.names]
        table = pandas.DataFrame(self.degrees, pandas.Index(self.times, name="time [s]"), columns)
        table.attrs.update(zero=self.zero, missing=dict(self.missing))
        return table

    def cycles(self, cycles: Any) -> DataFrame:
        """Convert the angles to a table of cycles over their phases, such as strides from 0 to 100 %.

        Parameters
        ----------
        cycles : GaitEvents, Repetitions or array-like of shape (n_cycles, 2)
            Where the cycles are:

            - `GaitEvents`: strides of each foot, from contact to contact. Angles of the trunk use the foot with more
              strides, and pelvis_rotation is relative to the direction of each stride.
            - `Repetitions`: the same cycles for both sides.
            - array of int: start and stop of each cycle, as in ``motion[start:stop]``.

        Returns
        -------
        pandas.DataFrame
            A row for each angle, cycle and per cent: columns "angle", such as "knee_flexion", "side" ("left", "right"
            or "middle"), "cycle", "start [s]", "phase [%]" and "value [deg]".

        Raises
        ------
        ImportError
            If pandas is not installed.
        ValueError
            Without cycles, and for cycles of a recording with frames at other times.

        See Also
        --------
        skpose.plot.JointAnglesDisplay : The curves as a picture.

        Notes
        -----
        Each cycle is interpolated linearly at 101 points in time, except across NaN and gaps of more than 0.1 s. Jumps
        of 360° are removed, and cycles that differ by whole turns are shifted onto each other. Mean, standard deviation
        and number of cycles: ``table.groupby(["angle", "side", "phase [%]"])["value [deg]"].agg(["mean", "std",
        "count"])``.

        Examples
        --------
        >>> import numpy as np
        >>> from skpose import Motion
        >>> from skpose.biomechanics import joint_angles
        >>> from skpose.datasets import humanoid
        >>> poses = np.zeros((61, 42))
        >>> poses[:, humanoid().dof_names.index("left_shank_rx")] = np.sin(np.linspace(0, 3 * np.pi, 61)) ** 2
        >>> table = joint_angles(Motion(humanoid(), poses, frame_rate=30)).cycles([(0, 21), (20, 41), (40, 61)])
        >>> knee = table[(table["angle"] == "knee_flexion") & (table["side"] == "left")]
        >>> knee.groupby("cycle")["value [deg]"].max().round(1).tolist()
        [57.3, 57.3, 57.3]
        """
        import pandas

        found, tables = find_cycles(self, cycles), []
        for name, curves in found.curves.items():
            stem, side = split_name(name)
            columns = {
                "angle": stem,
                "side": side or "middle",
                "cycle": np.repeat(np.arange(len(curves)), len(PHASES)),
                "start [s]": np.repeat(found.spans[side][:, 0], len(PHASES)),
                "phase [%]": np.tile(PHASES, len(curves)),
                "value [deg]": curves.ravel(),
            }
            tables.append(pandas.DataFrame(columns))
        return pandas.concat(tables, ignore_index=True)


@overload
def joint_angles(
    motion: Motion, *, zero: int | Motion | None = None, joints: Mapping[str, str] | None = None
) -> JointAngles: ...
@overload
def joint_angles(
    motion: Sequence[Motion] | MotionDataset,
    *,
    zero: int | Motion | Sequence[int | Motion] | None = None,
    joints: Mapping[str, str] | None = None,
) -> DataFrame: ...
def joint_angles(motion: Any, *, zero: Any = None, joints: Mapping[str, str] | None = None) -> Any:
    r"""Measure joint angles as defined in biomechanics, in degrees.

    Flexion, adduction and rotation of hip, knee, ankle, shoulder, elbow and wrist, the angles of trunk and neck, and
    the pelvis in the world. They depend on the orientations of the segments of the body, and not on the columns of a
    file: the order of Euler angles and the meaning of angle zero in the file have no effect.

    Parameters
    ----------
    motion : Motion, list of Motion or MotionDataset
        The motion of a person, or recordings of walks and runs.
    zero : int, Motion or list of these, default=None
        The standing pose with all angles zero: a frame of the motion, or a recording on the same skeleton, whose mean
        is taken. The person must stand upright in it. None takes the axes of the segments from the rest pose of the
        skeleton, which must stand, but may hold arms and knees in any way: straight limbs that hang down are at zero,
        and feet flat on the floor. A list has one for each recording.
    joints : Mapping of str to str, default=None
        Joints by landmark, such as ``{"left_knee": "KneeL"}``, for skeletons with unknown names, or to correct the
        joints found by name. Anatomy are hip, knee, ankle, ball, toe, shoulder, elbow, wrist and hand, each with
        "left\_" or "right\_", and head, head_top and head_center.

    Returns
    -------
    JointAngles
        A column for each angle that the skeleton has; `JointAngles.to_pandas` makes a dataframe.
    pandas.DataFrame
        Of a list or a dataset: the strides that `gait_events` finds in all recordings, as `JointAngles.cycles` has
        them, with the columns "subject" and "trial", as mixed models take them.

    Raises
    ------
    TypeError
        If `motion` has other elements than Motions, or `zero` is neither a frame nor a Motion.
    ValueError
        If the motion has no frames. If the joints of the legs are unknown, or `joints` do not fit a person: a knee that
        is not below the hip, one joint for two landmarks, exchanged sides. If the rest pose does not stand upright and
        there is no `zero`; if `zero` does not stand upright, or has another skeleton.

    Warns
    -----
    UserWarning
        If the person moves in the recording `zero`, or limbs are bent in it by 12° or more. If arms do not hang in
        `zero`: angles of shoulder and elbow, or of the elbow alone, are NaN.
    UserWarning
        If the skeleton is one of `fit_skeleton`, and there is no `zero`: its rest pose is the layout's.
    UserWarning
        If the person stands along another axis than ``motion.up`` in nearly all frames, and there is no `zero`.
    UserWarning
        If positions show only the line of the hips of the pelvis: its tilt is NaN, and the hips' angles are relative to
        the trunk.
    UserWarning
        If recordings of a list have no strides.

    See Also
    --------
    skpose.Motion.to_pandas : The columns of the skeleton, rad.

    Notes
    -----
    *Axes.* Each segment has the axes of the ISB [2]_ [3]_: x forward, y up, along limbs, z to the right. z is the line
    of the hips, and at knees and ankles the line through two points on both sides of the joint if the skeleton has
    them, such as markers of the epicondyles.

    *Angles.* Those of Grood and Suntay [1]_: flexion about z of the proximal segment, rotation about y of the distal
    one, adduction about the axis that is perpendicular to both. With :math:`R = R_z(\varphi) R_x(\psi) R_y(\rho)` they
    are :math:`\varphi, \psi, \rho` for the right side. Left limbs are mirrored, so that mirrored movements have equal
    angles. Rotation of the pelvis comes first, then list, then tilt [4]_, so that they do not depend on the heading.
    The shoulder also has the plane of elevation and the elevation [3]_.

    ================================  ====================================================
    positive                          is
    ================================  ====================================================
    ``pelvis_tilt``                   backward (posterior); OpenSim's sign
    ``pelvis_list``                   its right side down
    ``pelvis_rotation``               to the left, relative to zero
    ``trunk_extension``, ``neck_``    backward
    ``trunk_bending``, ``neck_``      to the right
    ``trunk_rotation``, ``neck_``     to the left
    ``hip_flexion``, ``shoulder_``    forward
    ``knee_flexion``                  backward, as a knee bends
    ``elbow_flexion``, ``wrist_``     the forearm forward; the palm to the forearm
    ``*_adduction``                   towards the middle
    ``*_rotation``                    internal
    ``ankle_dorsiflexion``            toes up
    ``ankle_inversion``               sole to the middle
    ``elbow_pronation``               from palms that face forward, to the middle
    ``wrist_ulnar_deviation``         towards the little finger
    ``shoulder_elevation``            from the trunk; 90 is horizontal
    ``shoulder_plane``                of the elevation: 0 to the side, 90 to the front
    ================================  ====================================================

    *Zero.* In nine tenths of the frames of `zero` thighs, shanks and trunk must be within 25° of the vertical, knees
    bent and thighs apart by at most 25°, upper arms within 25° of the trunk, and elbows bent by at most 45°. None of
    5,082 frames of CMU's walks and runs satisfies this. A rest pose may hold the arms out, as T-poses do: zero is then
    the straight arm lowered by the shortest path. Knees and elbows that are hinges bend about
    their own axes; other elbows about that of the path, which is wrong by up to 30° in some files, and so is the
    rotation of the shoulder. If arms point up at rest, the path is unknown, and these angles are NaN.

    *Missing values.* If two axes are parallel (within 3°), as for an arm held out to the side, flexion and rotation are
    indistinguishable. In a motion that is ``fitted`` to positions the rotation of a segment about itself is shown only
    by points off its line, or by the next joint if it is bent by 15° or more and a hinge: knees and elbows are taken
    for hinges. Otherwise rotations are NaN. Files of rotations have all of them, measured or not; BVH files of pose
    estimators have them too.

    *Accuracy.* From markers, flexion of hip and knee agrees with OpenSim's inverse kinematics by r ≥ 0.9985. Rotation
    of the hip is the least certain angle, r 0.63 to 0.92, as skin moves most at the thigh. An angle that is not zero in
    `zero`, such as that of elbows that are bent there, has an offset.

    Every call computes the forward kinematics of all frames, and a rotation for each joint: some 80 µs a frame.

    References
    ----------
    .. [1] E. S. Grood, W. J. Suntay, "A joint coordinate system for the clinical description of three-dimensional
       motions: application to the knee", J. Biomech. Eng. 105(2), 1983, :doi:`10.1115/1.3138397`.
    .. [2] G. Wu et al., "ISB recommendation on definitions of joint coordinate system of various joints for the
       reporting of human joint motion, part I: ankle, hip, and spine", J. Biomech. 35(4), 2002,
       :doi:`10.1016/S0021-9290(01)00222-6`.
    .. [3] G. Wu et al., part II: "shoulder, elbow, wrist and hand", J. Biomech. 38(5), 2005,
       :doi:`10.1016/j.jbiomech.2004.05.042`.
    .. [4] R. Baker, "Pelvic angles: a mathematically rigorous definition which is consistent with a conventional
       clinical understanding of the terms", Gait & Posture 13(1), 2001, :doi:`10.1016/S0966-6362(00)00083-7`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.biomechanics import joint_angles
    >>> from skpose.datasets import humanoid
    >>> skeleton = humanoid()
    >>> poses = np.zeros((2, skeleton.n_dofs))
    >>> poses[1, skeleton.dof_names.index("left_shank_rx")] = np.radians(60)
    >>> angles = joint_angles(Motion(skeleton, poses, frame_rate=30))
    >>> angles["knee_flexion_left"].round(6)
    array([ 0., 60.])
    """
    if isinstance(motion, Sequence | MotionDataset):
        return _tabulate_all(motion, zero, joints)
    check_kind(motion, Motion, "motion", "Motion(skeleton, poses, frame_rate) makes one of poses")
    if not len(motion):
        raise ValueError("joint_angles needs at least one frame, got none")
    person = find_person(motion.skeleton, joints)
    segments = find_segments(motion.skeleton, person)
    reference, words = find_zero(motion, zero, person, segments)
    columns, reasons, forward = measure(motion, segments, reference)
    names = tuple(columns)
    degrees = np.degrees(np.stack([columns[name] for name in names], axis=1))
    missing = {name: reasons[name] for name in names if np.isnan(columns[name]).any()}
    return JointAngles(names, degrees, motion.times, words, missing, forward)


def _tabulate_all(motions: Sequence[Motion] | MotionDataset, zero: Any, joints: Mapping[str, str] | None) -> Any:
    """A dataframe with the strides of several recordings."""
    import pandas

    n = len(motions)
    zeros = zero if isinstance(zero, Sequence) else [zero] * n
    labels = zip(getattr(motions, "subjects", [""] * n), getattr(motions, "trials", range(n)), strict=True)
    found = [
        (
            {"subject": subject, "trial": trial},
            joint_angles(motion, zero=one, joints=joints),
            gait_events(motion, joints=joints),
        )
        for motion, one, (subject, trial) in zip(motions, zeros, labels, strict=True)
    ]
    if without := [f"trial {label['trial']}: {events.reason}" for label, _, events in found if not len(events.strides)]:
        warn(f"{len(without)} of {n} recordings have no strides, such as {without[0]}")
    tables = [angles.cycles(events).assign(**label) for label, angles, events in found if len(events.strides)]
    return pandas.concat(tables, ignore_index=True)


# --- cycles -----------------------------------------------------------------------------------------------------------
# Where they are, and joint angles over their phases.


MIDDLE = ""  # the side of the angles of the trunk


class Cycles(NamedTuple):
    """The cycles of a movement."""

    spans: dict[str, np.ndarray]  # by side, (n_cycles, 2) first and last time, s
    curves: dict[str, np.ndarray]  # by angle, (n_cycles, 101) at `PHASES`
    noun: str
    of_middle: str  # the side whose cycles the trunk has; "" if all are the same


def split_name(angle: str) -> tuple[str, str]:
    """The name of an angle without its side, and the side."""
    stem, _, side = angle.rpartition("_")
    return (stem, side) if side in SIDES else (angle, MIDDLE)


def find_cycles(angles: Any, cycles: Any) -> Cycles:
    """The cycles of a recording, as given, and its `JointAngles` in them."""
    times = cycles.motion_times if isinstance(cycles, GaitEvents) else getattr(cycles, "times", None)
    if times is not None and (len(times) != len(angles) or not np.allclose(times, angles.times, rtol=0.0, atol=1e-6)):
        raise ValueError("cycles must be of the recording that angles are of, got another one")
    noun, of_middle, headings = "cycle", MIDDLE, np.zeros(1)
    if isinstance(cycles, GaitEvents):
        noun, (of_middle, spans, headings) = "stride", _find_strides(angles.forward, cycles)
    else:
        if isinstance(cycles, Repetitions):
            cycles, noun = np.stack([cycles.starts, cycles.stops], axis=1), "repetition"
        frames = np.asarray(cycles)
        if frames.shape[1:] != (2,) or not np.issubdtype(frames.dtype, np.integer):
            raise ValueError("cycles must be GaitEvents, Repetitions, or whole numbers of shape (n_cycles, 2)")
        if not len(frames) or frames.min() < 0 or frames.max() > len(angles) or (np.diff(frames) < 2).any():
            raise ValueError(f"cycles must be parts of at least two of the {len(angles)} frames of angles")
        spans = dict.fromkeys((*SIDES, MIDDLE), angles.times[frames - [0, 1]])
    zeros = dict.fromkeys(angles.names, np.zeros(1)) | {"pelvis_rotation": headings}
    curves = {
        name: over_phases(angles.times, angles[name], spans[split_name(name)[1]], zeros[name]) for name in angles.names
    }
    return Cycles(spans, curves, noun, of_middle)


def _find_strides(forward: np.ndarray | None, events: GaitEvents) -> tuple[str, dict[str, np.ndarray], np.ndarray]:
    """The foot with more strides, the strides of each foot, and the directions of those of the middle, degrees."""
    if not len(events.strides):
        raise ValueError(f"cycles has no strides: {events.reason}")
    strides = {side: events.strides[events.feet[events.strides[:, 0]] == side][:, [0, 2]] for side in SIDES}
    of_middle = max(strides, key=lambda side: len(strides[side]))  # the left, of equal ones
    strides[MIDDLE] = strides[of_middle]
    forward = np.zeros(3) if forward is None else forward
    along = np.diff(events.positions[strides[MIDDLE]], axis=1)[:, 0]
    headings = np.arctan2(along @ np.cross(np.eye(3)["xyz".index(events.up)], forward), along @ forward)
    return of_middle, {side: events.times[pairs] for side, pairs in strides.items()}, np.degrees(headings)
