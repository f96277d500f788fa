"""Movements in a stream: equality with the search in recordings, time a frame, memory over an hour, what is recognised.

    python benchmarks/stream.py [--hdm05 FOLDER] [--quick]

Without a folder the motions are generated gait. Four parts:

1. Equality: for each template and metric, what `MotionStream` returned is what `find_motion` finds in all frames.
2. Time of the processor a frame, one by one: 50 templates of two seconds, at 30 and 60 Hz, all metrics but "geodesic".
3. Memory: an hour at 30 Hz under "position", made of the motions in random order at random amplitudes.
4. Recognition under "position": templates are the motions of all people but one, of every second action. The stream is
   all motions of that person, with two seconds of standing before each: the one of their first poses that is nearest to
   the others, with noise. Motions of the other actions, standing, and noise of the columns' own mean and variance,
   smooth and white, are the controls: nothing is going on there. Known actions count from their first frame, in which
   nothing can be known yet.
"""

import itertools
import time
import tracemalloc
import warnings

import common
import numpy as np
from scipy.ndimage import gaussian_filter1d
from threadpoolctl import threadpool_limits

from skpose import pose_distances
from skpose.datasets import load_hdm05, make_gait
from skpose.motions import MotionStream, find_motion

METRICS = ("angle", "position", "rotation", "spatial")
N_TEMPLATES, SECONDS = 50, 2.0
HOUR = 3600  # s
RATE = 30  # Hz
NOISE = 0.01  # rad, of who stands
BINS = (0.0, 0.1, 0.2, 0.3, 0.4, 1.0)  # of sureness
LEAST = (0.0, 0.1, 0.2, 0.3)  # sureness of a label


def check_equality(templates, skeleton, frames, metric):
    """Refuse other matches than those of `find_motion`; return how many there are, and the largest difference."""
    nearest = [find_motion(t, [frames], k=1, skeleton=skeleton, metric=metric)[0].distance for t in templates]
    limit = 1.5 * float(np.median(nearest))
    stream = MotionStream(templates, skeleton=skeleton, metric=metric, max_distance=limit)
    matches = [match for frame in frames for match in stream.push(frame).matches]
    n_early = len(matches)
    matches += stream.finish()
    n, largest = 0, 0.0
    for i, template in enumerate(templates):
        found = sorted((m.distance, m.stop, m.start) for m in matches if m.template == i)
        expected = find_motion(template, [frames], k=len(frames), skeleton=skeleton, metric=metric)
        expected = sorted((m.distance, m.stop, m.start) for m in expected if m.distance <= limit)
        assert [m[1:] for m in found] == [m[1:] for m in expected], (metric, i)
        np.testing.assert_allclose([m[0] for m in found], [m[0] for m in expected], rtol=1e-12)
        n += len(found)
        largest = max([largest, *(abs(a[0] - b[0]) for a, b in zip(found, expected, strict=True))])
    return n, n_early, largest


def cut_templates(motions, rate, n_templates):
    """Return so many windows of SECONDS, evenly spaced in all motions."""
    n = round(SECONDS * rate)
    frames = np.concatenate(motions)
    starts = np.linspace(0, len(frames) - n, n_templates).astype(int)
    return [frames[s : s + n] for s in starts]


def endless(motions, n_frames, rng):
    """Yield frames: the motions in random order, at random amplitudes about their means, with a little noise."""
    while n_frames > 0:
        motion = motions[rng.integers(len(motions))][:n_frames]
        n_frames -= len(motion)
        mean = motion.mean(axis=0)
        yield from mean + (motion - mean) * rng.uniform(0.8, 1.2) + rng.normal(size=motion.shape) * 0.005


def measure_time(motions, skeleton, rate, metric, n_templates, n_frames):
    """Return median, 99th percentile and maximum of the processor's seconds of a frame, and the number of matches."""
    templates = cut_templates(motions, rate, n_templates)
    D = pose_distances(np.concatenate(templates)[::10], skeleton=skeleton, metric=metric)
    stream = MotionStream(templates, skeleton=skeleton, metric=metric, max_distance=float(np.median(D)) / 2)
    rng, seconds, n_matches = np.random.default_rng(0), [], 0
    for frame in endless(motions, n_frames, rng):
        start = time.process_time()
        state = stream.push(frame)
        seconds.append(time.process_time() - start)
        n_matches += len(state.matches)
    return np.median(seconds), np.quantile(seconds, 0.99), max(seconds[5:]), n_matches


def measure_memory(motions, skeleton, metric, n_templates, n_frames):
    """Print how much memory grows while frames come: of Python's objects and arrays, and of the process."""
    templates = cut_templates(motions, RATE, n_templates)
    D = pose_distances(np.concatenate(templates)[::10], skeleton=skeleton, metric=metric)
    stream = MotionStream(templates, skeleton=skeleton, metric=metric, max_distance=float(np.median(D)) / 2)
    rng, n_matches, most_kept, lines = np.random.default_rng(1), 0, 0, []
    tracemalloc.start()
    for t, frame in enumerate(endless(motions, n_frames, rng)):
        n_matches += len(stream.push(frame).matches)
        if t % 30 == 0:
            most_kept = max(most_kept, sum(windows.n_pending for windows in stream._windows))
        if (t + 1) % (n_frames // 6) == 0:
            traced = tracemalloc.get_traced_memory()[0] / 1e3
            lines.append((t + 1, traced, common.memory("VmRSS")))
    tracemalloc.stop()
    for t, traced, resident in lines:
        print(f"  after {t / RATE / 60:5.1f} min: {traced:8.0f} kB in arrays and objects, {resident:6.1f} MB resident")
    print(f"  {n_matches:,} matches, at most {most_kept} windows kept for {n_templates} templates")
    assert lines[-1][1] < 1.5 * lines[0][1] + 300.0, "memory grows"


def make_parts(poses, motions, actions, skeleton, metric, known, rng):
    """Yield the parts of a stream of one person: what it is, the action, which may be None, and the frames."""
    firsts = np.array([motion[0] for motion in motions])
    standing = firsts[pose_distances(firsts, skeleton=skeleton, metric=metric).sum(axis=0).argmin()]
    mean, std = np.concatenate(motions).mean(axis=0), poses.std(axis=0)
    white = rng.normal(size=(20 * RATE, len(mean)))
    smooth = gaussian_filter1d(white, RATE / 4, axis=0)
    yield "noise, white", None, mean + white * std
    yield "noise, smooth", None, mean + smooth / smooth.std() * std
    for i in rng.permutation(len(motions)):
        still = np.tile(standing, (2 * RATE, 1))
        yield "standing", None, still + rng.normal(size=still.shape) * NOISE
        yield ("known" if actions[i] in known else "other action"), actions[i], motions[i]


def recognise(dataset, metric):
    """Print what is recognised of each person, from templates of the others."""
    poses, sequence = dataset.poses(RATE)
    motions = [poses[sequence == i] for i in range(len(dataset))]
    subjects, actions = np.array(dataset.subjects), [str(action) for action in dataset.actions]
    names = sorted(set(actions))
    frames_of = {}  # of each phase, the sureness, 0 where no label is given, and whether the label is right
    n_events, n_found, n_false, minutes = 0, 0, 0, 0.0
    for known, person in itertools.product((set(names[::2]), set(names[1::2])), np.unique(subjects)):
        train = [i for i in range(len(motions)) if subjects[i] != person and actions[i] in known]
        test = np.flatnonzero(subjects == person)
        labels, rng = [actions[i] for i in train], np.random.default_rng(0)
        stream = MotionStream(
            [motions[i] for i in train],
            labels=labels,
            groups=subjects[train],
            skeleton=dataset.skeleton,
            metric=metric,
            min_sureness=0.0,
        )
        of_person = [motions[i] for i in test], [actions[i] for i in test]
        for kind, action, frames in make_parts(poses, *of_person, dataset.skeleton, metric, known, rng):
            if kind.startswith("noise"):
                stream.finish()
            found = []
            for t, frame in enumerate(frames):
                state = stream.push(frame)
                found += [match.label for match in state.matches]
                third = ("first third", "second third", "last third")[3 * t // len(frames)]
                second = "first second" if t < RATE else "from then on"
                phase = {"known": f"known, {third}", "standing": f"standing, {second}"}.get(kind, kind)
                right = state.label is not None and state.label == action
                frames_of.setdefault(phase, []).append((state.sureness, right))
            minutes += len(frames) / RATE / 60
            n_events += kind == "known"
            n_found += kind == "known" and action in found
            n_false += 0 if kind == "standing" else len(set(found) - {action})
    print(f"{metric}, frames with a label, right and wrong, in %, by the least sureness:")
    for phase in sorted(frames_of):
        sureness, right = np.array(frames_of[phase]).T
        shares = "; ".join(
            f"{least:g}: {100 * np.mean((sureness > least) & (right == 1)):4.1f} and "
            f"{100 * np.mean((sureness > least) & (right == 0)):4.1f}"
            for least in LEAST
        )
        print(f"  {phase:>22} ({len(right):,} frames): {shares}")
    sureness, right = np.concatenate([np.array(values) for values in frames_of.values()]).T
    for low, high in itertools.pairwise(BINS):
        chosen = (sureness > low) & (sureness <= high)
        if chosen.any():
            print(
                f"  sureness {low:g} to {high:g}: {100 * right[chosen].mean():.1f} % right of {chosen.sum():,} frames"
            )
    print(f"  {n_found} of {n_events} movements matched by their label; {n_false} other labels in {minutes:.0f} min")


if __name__ == "__main__":
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--hdm05", help="HDM05 files, see load_hdm05")
    arguments.add_argument("--part", choices=["equality", "time", "memory", "recognition"], help="one part alone")
    options = arguments.parse_args()
    common.print_machine()
    warnings.filterwarnings("ignore", message=".*templates move no more than", category=UserWarning)
    if options.hdm05:
        dataset = load_hdm05(options.hdm05)
    else:
        dataset = make_gait(3, 2 if options.quick else 4, duration=3, random_state=0)
    dataset = dataset.to_rotvec()
    skeleton = dataset.skeleton
    by_rate = {}
    for rate in (30, 60):
        poses, sequence = dataset.poses(rate)
        by_rate[rate] = [poses[sequence == i] for i in range(len(dataset))]
    n_templates = 6 if options.quick else N_TEMPLATES
    parts = {options.part} if options.part else {"equality", "time", "memory", "recognition"}
    with threadpool_limits(1):
        if "equality" in parts:
            frames = np.array(list(endless(by_rate[30], 300 if options.quick else 5000, np.random.default_rng(2))))
            for metric in METRICS:
                templates = cut_templates(by_rate[30], 30, 3 if options.quick else 10)
                n, n_early, largest = check_equality(templates, skeleton, frames, metric)
                print(
                    f"{metric}: {n} matches of {len(templates)} templates in {len(frames)} frames, {n_early} of them "
                    f"returned before the end, equal to find_motion's; distances differ by at most {largest:.1e}"
                )
        if "time" in parts:
            for rate, motions in by_rate.items():
                for metric in METRICS:
                    n_frames = 60 if options.quick else 3000
                    median, late, most, n = measure_time(motions, skeleton, rate, metric, n_templates, n_frames)
                    print(
                        f"{metric}, {n_templates} templates at {rate} Hz: {1e3 * median:.2f} ms a frame, 1 % above "
                        f"{1e3 * late:.2f} ms, at most {1e3 * most:.1f} ms; {n} matches"
                    )
        if "memory" in parts:
            print(f"position, {n_templates} templates, {RATE} Hz:")
            measure_memory(by_rate[30], skeleton, "position", n_templates, 600 if options.quick else HOUR * RATE)
        if "recognition" in parts:
            recognise(dataset, "position")
