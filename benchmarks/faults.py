"""Faults that check_motion finds, and false alarms.

    python benchmarks/faults.py [--cmu FOLDER OF CMU FILES] [--hdm05 FOLDER OF HDM05 FILES] [--quick]

Every second recording is untouched first: how many have findings of each kind. Then walks, runs and jumps, kicks,
swordplay and so on get one fault each, of three sizes. A fault is found if there is a finding of its kind that the
untouched recording does not have. Thresholds were chosen on all of these recordings, so false alarms elsewhere may be
more frequent.
"""

import time
from collections import Counter
from dataclasses import replace

import common
import numpy as np

from skpose import Skeleton
from skpose.checks import check_motion
from skpose.datasets import load_cmu, load_hdm05, make_actions

options = common.parser_of_both(__doc__).parse_args()
common.print_machine()
EACH = 2 if options.quick else 10  # recordings of each group
THIGH, SHANK = ("lfemur_rx", "ltibia_rx") if options.cmu or options.hdm05 else ("left_thigh_rx", "left_shank_rx")
GROUPS = {"walk": "walk", "run": "run|jog", "other": "kick|hop|jump|sword|rotate|throw|punch"}
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
    other = {"l": "r", "r": "l"}
    names = {b.name: other.get(b.name[0], "") + b.name[1:] for b in motion.skeleton.bones if b.name[0] in other}
    names = {name: new for name, new in names.items() if new in names}
    bones = [
        b._replace(name=names.get(b.name, b.name), parent=names.get(b.parent, b.parent)) for b in motion.skeleton.bones
    ]
    return replace(motion, skeleton=Skeleton(bones))


def scaled(motion, factor):
    bones = [bone._replace(offset=tuple(factor * x for x in bone.offset)) for bone in motion.skeleton.bones]
    return replace(motion, skeleton=Skeleton(bones), root_positions=factor * motion.root_positions)


def filled(motion, n):
    """The middle n frames on straight lines."""
    at = np.arange(len(motion))
    kept = np.r_[: len(at) // 2, len(at) // 2 + n : len(at)]
    arrays = {}
    for name in ("angles", "root_positions", "root_angles"):
        values = np.unwrap(getattr(motion, name), axis=0) if "angles" in name else getattr(motion, name)
        arrays[name] = np.stack([np.interp(at, kept, column[kept]) for column in values.T], axis=1)
    return replace(motion, **arrays)


def part(motion):
    """The middle third, as a mask."""
    at = np.arange(len(motion)) / len(motion)
    return (at > 1 / 3) & (at < 2 / 3)


def middle(motion, n=1):
    return slice(len(motion) // 2, len(motion) // 2 + n)


def missing(motion, n):
    kept = np.r_[: len(motion) // 2, len(motion) // 2 + n : len(motion)]
    return replace(rows_of(motion, kept), frame_numbers=kept)


def frozen(motion, n):
    rows = np.arange(len(motion))
    rows[middle(motion, n)] = rows[middle(motion).start - 1]
    return rows_of(motion, rows)


def noisy(motion, degrees):
    return replace(motion, angles=motion.angles + rng.normal(0.0, np.radians(degrees), motion.angles.shape))


def off_path(motion, cm, frames):
    return moved(motion, np.isin(np.arange(len(motion)), len(motion) // 2 + frames)[:, None] * 0.01 * cm * ALONG)


def sliding(motion, speed):
    return moved(motion, np.cumsum(part(motion))[:, None] * speed / motion.frame_rate * ALONG)


def knees_bent(motion, degrees):
    is_knee = np.array(motion.skeleton.dof_names) == SHANK
    return replace(motion, angles=np.where(is_knee, -np.radians(degrees), motion.angles))


FLOATS = "floating", "sinking"  # relative to the floor on which a short motion stands most
# fault: (kind of the finding, sizes, the motion with a fault of a size)
FAULTS = {
    "scale of the file, ×": ("units", (2.0, 2.54, 100.0), scaled),
    "up axis": ("up axis", ("x", "z", "z"), lambda m, up: replace(m, up=up)),
    "frame rate, ×": ("frame rate", (0.5, 2.0, 4.0), lambda m, f: replace(m, frame_rate=f * m.frame_rate)),
    "missing frames": ("missing frames", (1, 3, 10), missing),
    "frozen frames": ("repeated frames", (1, 3, 10), frozen),
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
    "floats for a third, cm": (FLOATS, (4, 8, 16), lambda m, cm: moved(m, 0.01 * cm * part(m))),
    "sinks for a third, cm": (FLOATS, (4, 8, 16), lambda m, cm: moved(m, -0.01 * cm * part(m))),
    "slides for a third, m/s": ("skating", (0.2, 0.5, 1.0), sliding),
    "root travels, ×": (
        "skating",
        (0.8, 0.6, 0.0),
        lambda m, f: replace(m, root_positions=m.root_positions * [f, 1.0, f]),
    ),
    "sides exchanged": ("sides exchanged", (1, 1, 1), lambda m, _: renamed(m)),
    "knee bends forward, °": ("joint limits", (20, 40, 80), knees_bent),
}
PAIRS = {
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


def main():
    loaded = [(load_cmu, options.cmu), (load_hdm05, options.hdm05)]
    sets = [load(folder, rotations="file") for load, folder in loaded if folder]
    sets = sets or [make_actions(2, 1, rotations="file", random_state=0)]
    recordings = [(action, motion) for one in sets for action, motion in zip(one.actions, one, strict=True)]
    half = recordings[1::2]
    begin = time.perf_counter()
    findings = check_motion(motion for _, motion in half)
    seconds = (time.perf_counter() - begin) / len(half)
    counts = Counter(kind for kind, _ in {(one.kind, one.motion) for one in findings})
    print(f"{len(half)} untouched recordings, {seconds:.3f} s each: {dict(counts.most_common())}")
    for one in findings:
        print(f"    {half[one.motion][0]}: {one}")
    groups = {
        name: [motion for action, motion in half if any(word in action for word in words.split("|"))][:EACH]
        for name, words in GROUPS.items()
    }
    before = {name: [known(motion) for motion in motions] for name, motions in groups.items()}
    print("\n| fault | sizes |", " | ".join(f"{name} ({len(some)})" for name, some in groups.items()), "|")
    print("|---|---|---|---|---|")
    for fault, (kind, sizes, make) in {**FAULTS, **PAIRS}.items():
        cells = []
        for name, motions in groups.items():
            counts = []
            for size in sizes:
                made = [make(motion, size) for motion in motions]
                shown = [known([m, f] if fault in PAIRS else f) for m, f in zip(motions, made, strict=True)]
                new = [any(one[0].endswith(kind) for one in s - b) for s, b in zip(shown, before[name], strict=True)]
                counts.append(str(sum(new)))
            cells.append(", ".join(counts))
        print(f"| {fault} | {', '.join(map(str, sizes))} |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
