"""All checks of motions."""

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from skpose._utils.validation import check_kind
from skpose.checks import _measures
from skpose.checks._collection import compare, summarise
from skpose.checks._findings import APART, KINDS, SEVERITIES, Finding, Kind
from skpose.checks._recording import Recording, Unknown
from skpose.skeleton import Motion

LENGTHS = "m", "m/s", "mm"
WHOLE = "units", "up axis"  # without these nothing is known of the rest


def check_motion(motions: Motion | Iterable[Motion]) -> list[Finding]:
    """Find faults of motions: of files that are read wrongly, of recordings, and of generated motion.

    Parameters
    ----------
    motions : Motion, MotionDataset or iterable of Motion
        One motion, or several, which are also compared with each other; an iterable is read once, and only a summary of
        each motion is kept.

    Returns
    -------
    list of Finding
        Errors first, then warnings and notes, each with the attributes `severity`, `kind`, `motion` (its index),
        `frames` (first and the one after the last), `joints`, `size`, `unit`, `what` and `remedy`;
        ``pandas.DataFrame(findings)`` is a table, and ``str(finding)`` a sentence.

    Raises
    ------
    TypeError
        If an element is not a Motion.

    See Also
    --------
    skpose.scores.foot_skating : A score instead of places.
    skpose.statistics.outlier_test : A test of motions against a set.

    Notes
    -----
    Kinds are, of one motion: units, up axis, frame rate, missing, repeated and interpolated frames, jump, noise, angle
    flips, calibration pose, floor, floating, sinking, skating, sides exchanged, joint limits (of knees). Of several:
    duplicate, near duplicate, mixture, unlike others. `skpose.checks._findings` has their thresholds. A motion without
    frames is an error, too. Feet, knees and sides need a person's legs, the calibration pose arms, the floor a root
    that moves.

    A motion that is sound in all respects can still be unlike people.

    Examples
    --------
    A kick whose frames from the 60th on are its 60th:

    >>> from dataclasses import replace
    >>> import numpy as np
    >>> from skpose.checks import check_motion
    >>> from skpose.datasets import make_actions
    >>> kick = make_actions(1, 1, actions=["kick"], random_state=0)[0]
    >>> check_motion(kick)
    []
    >>> rows = np.minimum(np.arange(len(kick)), 60)
    >>> stops = replace(kick, angles=kick.angles[rows], root_positions=kick.root_positions[rows],
    ...                 root_angles=kick.root_angles[rows])
    >>> for finding in check_motion(stops):
    ...     print(finding.kind, finding.frames, finding.what)
    repeated frames (61, 114) 53 frames repeat the one before
    """
    return check_all([motions] if isinstance(motions, Motion) else motions, "motion {}".format)


def check_all(motions: Iterable[Motion], name_of: Callable[[int], str]) -> list[Finding]:
    """The findings of motions with names, which are known after they are read."""
    findings: list[Finding] = []
    summaries = []
    for number, motion in enumerate(motions):
        check_kind(motion, Motion, "motion", "pass a Motion or several")
        if not len(motion):
            what = "the motion has no frames"
            findings.append(Finding("error", "no frames", number, (0, 0), (), 0.0, "frames", what, "leave it out"))
            continue
        recording = Recording(motion)
        findings += check_recording(recording, number)
        summaries.append(summarise(recording, number))
    findings += compare(summaries, name_of)
    return sorted(findings, key=lambda one: (SEVERITIES.index(one.severity), one.motion, one.frames))


def check_recording(recording: Recording, number: int, kinds: dict[str, Kind] = KINDS) -> Iterator[Finding]:
    for name, kind in kinds.items():
        try:
            measured = getattr(_measures, name.replace(" ", "_"))(recording)
        except Unknown:
            continue
        sizes = np.broadcast_to(measured.sizes, (len(recording.points), *measured.sizes.shape[1:]))
        sizes = sizes.reshape(len(sizes), -1)
        over = np.flatnonzero((sizes > kind.limit).any(axis=1))
        longest = 1.0 if kind.seconds else max(1.0, APART / recording.step)  # between two frames of an event
        apart = 1 + np.flatnonzero(np.diff(over) > longest)
        for event in np.split(over, apart) if len(over) else ():
            frames = int(event[0]), int(event[-1]) + 1
            if len(event) < kind.least or len(event) * recording.step < kind.seconds:
                continue
            largest = sizes[event].max(axis=0)
            worst = [i for i in np.argsort(-largest)[:3] if largest[i] > kind.limit]
            joints = tuple(measured.names[i] for i in worst if measured.names)
            size = float(largest.max()) * (recording.scale if kind.unit in LENGTHS else 1.0)
            words = {"n": len(event), "first": frames[0], "joint": " ".join(joints[:1]), "note": measured.note}
            what = kind.what.format(size=size, **words)
            yield Finding(kind.severity, name, number, frames, joints, size, kind.unit, what, kind.remedy)
            if name in WHOLE:
                return
