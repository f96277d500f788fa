"""All checks of motions."""

from collections.abc import Callable, Iterable

from skpose._utils.validation import check_kind
from skpose.checks import _body, _frames  # noqa: F401  # which register the checks
from skpose.checks._collection import compare, summarise
from skpose.checks._findings import CHECKS, SEVERITIES, Finding
from skpose.checks._recording import Recording
from skpose.skeleton import Motion

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
    Kinds are, of one motion: missing, repeated and interpolated frames, root jump, joint jump, noise, angle flips,
    units, up axis, frame rate, calibration pose, floor, floating, sinking, skating, travel, sides exchanged, joint
    limits. Of several: duplicate, near duplicate, mixture, unlike others. Their thresholds are in
    `skpose.checks._findings`, with the largest values of real recordings without the fault. Checks of feet, knees and
    sides need the legs of a person; those of the floor and of travel, a root that moves.

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
    repeated frames (60, 114) 53 of 114 frames repeat the one before, at most 53 in a row
    """
    return check_all([motions] if isinstance(motions, Motion) else motions, "motion {}".format)


def check_all(motions: Iterable[Motion], name_of: Callable[[int], str]) -> list[Finding]:
    """The findings of motions with names, which are known after they are read."""
    findings: list[Finding] = []
    summaries = []
    for number, motion in enumerate(motions):
        check_kind(motion, Motion, "motion", "pass a Motion or several")
        if not len(motion):
            whole = "error", "no frames", number, (0, 0), (), 0.0, "frames"
            findings.append(Finding(*whole, "the motion has no frames", "leave it out"))
            continue
        recording = Recording(motion)
        findings += check_recording(recording, number)
        summaries.append((number, summarise(recording)))
    findings += compare(summaries, name_of)
    return sorted(findings, key=lambda one: (SEVERITIES.index(one.severity), one.motion, one.frames))


def check_recording(recording: Recording, number: int) -> list[Finding]:
    findings = []
    for kind, check in CHECKS.items():
        for found in check.find(recording):
            frames, remedy = found.frames or (0, len(recording.motion)), found.remedy or check.remedy
            head = check.severity, kind, number, frames, found.joints, found.size, found.unit
            findings.append(Finding(*head, found.what, remedy))
        if findings and findings[-1].kind in WHOLE:
            return findings
    return findings
