"""Faults that check_motion finds, and false alarms.

    python benchmarks/faults.py [--cmu FOLDER OF CMU FILES] [--hdm05 FOLDER OF HDM05 FILES] [--quick]

Limits of `skpose.checks` are chosen on the people of TRAINING, by one rule. At most 1 % of their recordings may have a
finding that is not TRUE, at their own rate or at every fourth frame. Of the values 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8,
10, ... the rule takes the most sensitive one for which this holds, and then the next, less sensitive one, since other
people move otherwise. Meanwhile the other limits stay as they are.

All that follows is of the other people: first their recordings, untouched; then walks, runs, and jumps, kicks, squats
and so on with one fault each, of three sizes. A fault is found if there is a finding of its kind that the untouched
recording does not have; else it is missed.
"""

import re
from bisect import bisect_left
from collections import Counter
from dataclasses import replace
from unittest.mock import patch

import common
import numpy as np

from skpose import Skeleton
from skpose.checks import _collection, _measures, check_motion
from skpose.checks._check import check_recording
from skpose.checks._findings import KINDS
from skpose.checks._recording import Recording

options = common.parser_of_both(__doc__).parse_args()
common.print_machine()
EACH = 2 if options.quick else 10  # recordings of each group
THIGH, SHANK = ("lfemur_rx", "ltibia_rx") if options.cmu or options.hdm05 else ("left_thigh_rx", "left_shank_rx")
GROUPS = {"walk": "walk|sneak", "run": "run|jog", "other": "kick|hop|rotate|throw|squat|grab"}
TRAINING = "02", "03", "09", "bd", "dg"  # the others of CMU and HDM05 are 07, 35 and bk
SERIES = [x * 10.0**power for power in range(-4, 4) for x in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8)]
# Limits of kinds, and constants of modules.
LIMITS = [
    *((kind, None, "limit") for kind in ("jump", "noise", "floor", "floating", "sinking", "skating")),
    ("jump", _measures, "SUDDEN"),
    ("interpolated frames", _measures, "LINEAR"),
    ("near duplicate", _collection, "NEAR"),
    ("unlike others", _collection, "UNLIKE"),
]
# Recordings that were looked at: bones turn by 180° in a frame, or leave for one; both of subject 03 are noisy, on a
# floor that is not level.
TRUE = {
    "jump": "02 (02|07|09|10)|03 0[12]|07 05|09 06|35 (06|33)|bd throw.*_00[23]|bk deposit.*_0(07|09|11)"
    "|bk kickL.*_011|dg deposit.*_018|dg lie.*_01[1-4]|dg squat.*_0(25|26|27|28|30|31|32)|dg throw.*_00[789]",
    "noise": "03",
    "floor": "03",
    "floating": "03",
    "repeated frames": "03 02|35 22",
    "calibration pose": "03 02",
    "joint limits": "dg lieDownFloor_014",
    "angle flips": "",
    "mixture": "",
}
rng, ALONG = np.random.default_rng(0), np.array([0.0, 0.0, 1.0])  # horizontal, as y points up


def rows_of(motion, rows):
    arrays = {name: getattr(motion, name)[rows] for name in ("angles", "root_positions", "root_angles")}
    return replace(motion, frame_numbers=np.arange(len(rows)), **arrays)


def moved(motion, path):
    """The root moved upwards, (n_frames,), or by (n_frames, 3)."""
    path = path[:, None] * [0.0, 1.0, 0.0] if path.ndim == 1 else path
    return replace(motion, root_positions=motion.root_positions + path)


def turned(motion, joint, degrees, frames):
    angles = motion.angles.copy()
    angles[frames, motion.skeleton.dof_names.index(joint)] += np.radians(degrees)
    return replace(motion, angles=angles)


def renamed(motion):
    """Left and right have each other's names."""
    names = {name: {"l": "r", "r": "l"}.get(name[0], "") + name[1:] for name in motion.skeleton.joint_names}
    new = {name: other for name, other in names.items() if other in names}
    bones = [
        b._replace(name=new.get(b.name, b.name), parent=new.get(b.parent, b.parent)) for b in motion.skeleton.bones
    ]
    return replace(motion, skeleton=Skeleton(bones))


def scaled(motion, factor):
    bones = [bone._replace(offset=tuple(factor * x for x in bone.offset)) for bone in motion.skeleton.bones]
    return replace(motion, skeleton=Skeleton(bones), root_positions=factor * motion.root_positions)


def filled(motion, n):
    """The middle n frames on straight lines."""
    motion = rows_of(motion.unwrap(), np.arange(len(motion)))
    for values in (motion.angles, motion.root_positions, motion.root_angles):
        values[middle(motion, n)] = np.linspace(*values[[len(motion) // 2 - 1, len(motion) // 2 + n]], n + 2)[1:-1]
    return motion


def part(motion):
    """The middle third, as a mask."""
    at = np.arange(len(motion)) / len(motion)
    return (at > 1 / 3) & (at < 2 / 3)


def middle(motion, n=1):
    return slice(len(motion) // 2, len(motion) // 2 + n)


def missing(motion, n):
    kept = np.r_[: len(motion) // 2, len(motion) // 2 + n : len(motion)]
    return replace(rows_of(motion, kept), frame_numbers=kept)


def noisy(motion, degrees):
    return replace(motion, angles=motion.angles + rng.normal(0.0, np.radians(degrees), motion.angles.shape))


def off_path(motion, cm, frames):
    return moved(motion, np.isin(np.arange(len(motion)), len(motion) // 2 + frames)[:, None] * 0.01 * cm * ALONG)


# fault: (kind of the finding, sizes, the motion with a fault of a size)
FAULTS = {
    "scale of the file, ×": ("units", (2.0, 2.54, 100.0), scaled),
    "up axis": ("up axis", ("x", "z", "z"), lambda m, up: replace(m, up=up)),
    "frame rate, ×": ("frame rate", (0.5, 2.0, 4.0), lambda m, f: replace(m, frame_rate=f * m.frame_rate)),
    "missing frames": ("missing frames", (1, 3, 10), missing),
    "frozen frames": (
        "repeated frames",
        (1, 3, 10),
        lambda m, n: rows_of(m, np.r_[: len(m) // 2, [len(m) // 2 - 1] * n, len(m) // 2 + n : len(m)]),
    ),
    "every n-th frame doubled": (
        "repeated frames",
        (10, 4, 2),
        lambda m, n: rows_of(m, [i - (i % n == n - 1) for i in range(len(m))]),
    ),
    "gap filled linearly, frames": ("interpolated frames", (4, 8, 16), filled),
    "upsampled by slerp, ×": ("interpolated frames", (2, 3, 4), lambda m, n: m[::n].resample(m.frame_rate)),
    "root jumps, cm": ("jump", (2, 5, 15), lambda m, cm: off_path(m, cm, np.arange(len(m)))),
    "root leaves for a frame, cm": ("jump", (2, 5, 15), lambda m, cm: off_path(m, cm, np.zeros(1))),
    "thigh leaves for a frame, °": ("jump", (3, 10, 30), lambda m, d: turned(m, THIGH, d, middle(m))),
    "thigh turns for good, °": ("jump", (3, 10, 30), lambda m, d: turned(m, THIGH, d, middle(m, 10**6))),
    "noise of angles, °": ("noise", (0.1, 0.3, 1.0), noisy),
    "noise of the root, mm": ("noise", (1, 3, 10), lambda m, mm: moved(m, rng.normal(0.0, 1e-3 * mm, (len(m), 3)))),
    "angles by 360°, frames": ("angle flips", (1, 3, 10), lambda m, n: turned(m, THIGH, 360.0, middle(m, n))),
    "pose zero at the start, frames": (
        "calibration pose",
        (1, 5, 30),
        lambda m, n: replace(m, angles=np.where(np.arange(len(m))[:, None] < n, 0.0, m.angles)),
    ),
    "floor, cm": ("floor", (5, 10, 20), lambda m, cm: moved(m, np.full(len(m), 0.01 * cm))),
    "floats for a third, cm": (("floating", "sinking"), (4, 8, 16), lambda m, cm: moved(m, 0.01 * cm * part(m))),
    "sinks for a third, cm": (("floating", "sinking"), (4, 8, 16), lambda m, cm: moved(m, -0.01 * cm * part(m))),
    "slides for a third, m/s": (
        "skating",
        (0.2, 0.5, 1.0),
        lambda m, v: moved(m, np.cumsum(part(m))[:, None] * v / m.frame_rate * ALONG),
    ),
    "root travels, ×": (
        "skating",
        (0.8, 0.6, 0.0),
        lambda m, f: replace(m, root_positions=m.root_positions * [f, 1.0, f]),
    ),
    "sides exchanged": ("sides exchanged", (1, 1, 1), lambda m, _: renamed(m)),
    "knee bends forward, °": (
        "joint limits",
        (20, 40, 80),
        lambda m, d: replace(m, angles=np.where(np.isin(m.skeleton.dof_names, SHANK), -np.radians(d), m.angles)),
    ),
    "copy, noise in °": ("duplicate", (0.0, 0.1, 0.5), noisy),
    "copy at another frame rate, ×": (
        "duplicate",
        (0.5, 2.0, 4.0),
        lambda m, f: replace(m, frame_rate=f * m.frame_rate),
    ),
    "mirror image": ("duplicate", (1, 1, 1), lambda m, _: m.mirrored("x")),
    "copy, moved root, m/s": ("duplicate", (0.1, 1.0, 5.0), lambda m, d: moved(m, m.times[:, None] * d * ALONG)),
    "copy, cut by %": ("duplicate", (1, 3, 10), lambda m, p: m[: int(len(m) * (1 - 0.01 * p))]),
}


def known(motions):
    """Kinds and frames of all findings, with sizes rounded to a tenth of themselves."""
    return {(one.kind, one.frames, float(f"{one.size:.1g}")) for one in check_motion(motions)}


def found(motion, before, fault, size):
    """Whether a fault is found, where a motion has known findings without it."""
    kind, _, make = FAULTS[fault]
    made = make(motion, size)
    return any(one[0].endswith(kind) for one in known([motion, made] if kind == "duplicate" else made) - before)


def untrue(findings, names):
    """Kinds of findings that are not true, and names of motions with them."""
    pairs = {(one.kind, names[one.motion]) for one in findings}
    return {(kind, name) for kind, name in pairs if not re.match(TRUE.get(kind, "$"), name)}


def chosen(kind, module, limit, training):
    """The value of a limit by the rule, for names and recordings, each followed by every fourth frame of it."""
    names, recordings = zip(*training, strict=True)
    own = {kind: KINDS[kind]} if kind in KINDS else {}  # all others are of collections
    summaries = [] if own else [_collection.summarise(one, 2 * i) for i, one in enumerate(recordings[::2])]
    values = SERIES[::-1] if limit in ("LINEAR", "NEAR") else SERIES  # the most sensitive first

    def holds(value):
        with (
            patch.object(module, limit, value) if module else patch.dict(own, {kind: KINDS[kind]._replace(limit=value)})
        ):
            findings = [one for i, recording in enumerate(recordings) for one in check_recording(recording, i, own)]
            findings += _collection.compare(summaries, str)
        return len(untrue(findings, names)) <= 0.01 * len(recordings[::2])

    return values[bisect_left(values, True, key=holds) + 1]


def main():
    motions = [
        (str(subject), f"{subject} {trial}", action, motion)
        for one in common.datasets(options).values()
        for subject, trial, action, motion in zip(one.subjects, one.trials, one.actions, one, strict=True)
    ]
    training = [
        (name, Recording(one)) for who, name, _, motion in motions if who in TRAINING for one in (motion, motion[::4])
    ]
    print(f"{len(training) // 2} recordings of training people; limits by the rule, and in skpose:")
    for kind, module, limit in LIMITS:
        value = chosen(kind, module, limit, training)
        print(f"    {kind}, {limit}: {value:.3g}, {getattr(module or KINDS[kind], limit):.3g}", flush=True)
    others = [motions[i] for i in rng.permutation(len(motions)) if motions[i][0] not in TRAINING]
    findings = check_motion(motion for *_, motion in others)
    counts = Counter(kind for kind, _ in {(one.kind, one.motion) for one in findings})
    print(f"{len(others)} untouched recordings of the others: {dict(counts.most_common())}")
    print("not true:", sorted(untrue(findings, [name for _, name, *_ in others])))
    groups = {
        name: [(motion, known(motion)) for *_, action, motion in others if re.search(words, action)][:EACH]
        for name, words in GROUPS.items()
    }
    print(
        "\n| fault | sizes |",
        " | ".join(f"{name} ({len(some)})" for name, some in groups.items()),
        "|\n|---|---|---|---|---|",
    )
    for fault, (_, sizes, _) in FAULTS.items():
        counts = [[sum(found(*one, fault, size) for one in some) for size in sizes] for some in groups.values()]
        print("|", " | ".join([fault, *(", ".join(map(str, one)) for one in (sizes, *counts))]), "|", flush=True)


if __name__ == "__main__":
    main()
