"""Spreads of actions: how differently do people do the same thing, and one person from one repetition to the next?

    python benchmarks/action_spreads.py [FOLDER OF HDM05 FILES] [--seeds N] [--quick]

The figures from which `skpose.datasets.make_actions` draws, measured on the actions of HDM05 that people do on their
feet: all but those of which the label begins with "lie". Without a folder it measures generated actions.

1. Every recording is put on the joints of `skpose.datasets.humanoid`, see `benchmarks/spreads.py`.
2. The recordings of an action are brought to one time, from 0 to 1: that of the one whose sum of distances to the
   others is least, by dynamic time warping under "position" at 30 Hz. Nine phases of it are looked at.
3. At each phase a joint has a mean rotation, of people with equal weights. The deviation of a recording is the rotation
   from that to its own, about the joint's own axes, in degrees; of hinges, the difference of the angles.
4. The mean of a recording's deviations over the phases is how it differs all the time: action + person + the person in
   this action + recording, of which the first two are fixed and the others random. What is left at each phase is how
   it differs there: action + the person in this action + recording, and the mean square over the phases counts. That
   gives four standard deviations of each dof, by restricted maximum likelihood; of dofs of the left and of the right
   the root mean square of both. What a person does in all actions is measured by `benchmarks/spreads.py`, on more
   people.
5. The tempo is the logarithm of the duration. The timing is what the warping of 2. has of the curve 4 s (1 − s), at the
   time s: by how much of its duration a recording is late in the middle. Their model is action + the person in this
   action + recording.

`--seeds N` recognises the actions that `make_actions` generates from N seeds, as `skpose compare` does, and prints mean
and standard deviation over the seeds.

Three people and ten actions leave 20 degrees of freedom between people: the interval of 95 %, by the chi-squared
distribution, is from 0.77 to 1.44 times the figure, and as people differ in some actions far more than in others it is
wider than that.
"""

from typing import NamedTuple

import common
import numpy as np
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation
from spreads import DOFS, Design, components, on_humanoid

from skpose._cli.studies.compare import COMPARED, Result, compare, prepare
from skpose.datasets import MotionDataset, load_hdm05, make_actions
from skpose.datasets._action_spreads import Execution
from skpose.motions import align_motions, motion_distances

PHASES = np.linspace(0.0, 1.0, 9)
RATE = 30.0  # Hz, at which recordings are aligned
BUMP = 4.0 * PHASES * (1.0 - PHASES)


class Recordings(NamedTuple):
    """Rows are recordings."""

    action: np.ndarray
    person: np.ndarray
    deviations: np.ndarray  # (n, n_phases, 42), degrees
    tempo: np.ndarray  # (n,) logarithm of the duration in seconds
    timing: np.ndarray  # (n,) share of the duration


class Spreads(NamedTuple):
    """What is measured."""

    execution: dict[str, Execution]
    tempo: tuple[float, float]  # of the person in an action, of the recording
    timing: tuple[float, float]


def on_feet(dataset):
    """The motions of people who stand."""
    return dataset[[not action.startswith("lie") for action in dataset.actions]]


def warp(motions):
    """The time (n, n_phases) of each motion, from 0 to 1, at the phases of the most typical one."""
    dataset = MotionDataset([motion.resample(RATE).to_rotvec() for motion in motions])
    sums = motion_distances(dataset, metric="position", n_jobs=-1).sum(axis=1)
    typical = dataset[int(sums.argmin())]
    found = []
    for motion in dataset:
        i, j = align_motions(typical, motion, skeleton=dataset.skeleton, metric="position").path.T
        of_frame = np.bincount(i, weights=j) / np.bincount(i)  # the frames of a typical one have, in the mean
        frames = np.interp(PHASES * (len(typical) - 1), np.arange(len(typical)), of_frame)
        found.append(frames / (len(motion) - 1))
    return np.array(found)


def deviations(poses, weights):
    """Deviations (n, n_phases, 42), degrees, of poses on the humanoid from their mean at each phase."""
    found = np.empty_like(poses)
    names = [name[:-3] for name in DOFS]
    for name in dict.fromkeys(names):
        columns = [c for c, other in enumerate(names) if other == name]
        for k in range(len(PHASES)):
            some = poses[:, k, columns]
            if len(columns) == 3:
                rotations = Rotation.from_euler("xyz", some, degrees=True)
                found[:, k, columns] = np.degrees((rotations.mean(weights).inv() * rotations).as_rotvec())
            else:
                around = np.exp(1j * np.radians(some))
                found[:, k, columns] = np.degrees(np.angle(around / np.average(around, axis=0, weights=weights)))
    return found


def recordings(dataset):
    """Measure the recordings of a dataset."""
    n = len(dataset)
    tempo = np.log([(len(motion) - 1) / motion.frame_rate for motion in dataset])
    found = Recordings(dataset.actions, dataset.subjects, np.empty((n, len(PHASES), 42)), tempo, np.empty(n))
    for action in sorted(set(dataset.actions)):
        of = np.flatnonzero(dataset.actions == action)
        times = warp([dataset[i] for i in of])
        found.timing[of] = (times - PHASES) @ BUMP / (BUMP @ BUMP)
        poses = []
        for i, time in zip(of, times, strict=True):
            poses.append(on_humanoid(dataset[i])[0][np.rint(time * (len(dataset[i]) - 1)).astype(int)])
        people = dataset.subjects[of]
        weights = np.array([1.0 / np.sum(people == person) for person in people])
        found.deviations[of] = deviations(np.array(poses), weights)
    return found


def indicators(labels):
    """A column for each label."""
    return np.equal.outer(labels, np.unique(labels)).astype(float)


def design(fixed, random):
    """The design of a model with fixed effects of several labels, and one random effect."""
    Z = indicators(random)
    K = null_space(np.hstack([indicators(labels) for labels in fixed]).T)
    d, U = np.linalg.eigh(K.T @ Z @ Z.T @ K)
    return Design((K @ U).T, np.where(d > 1e-9, d, 0.0))


def designs(recorded):
    """The designs of what is constant in a recording, and of what is not; the number of degrees of freedom of the
    second is that of people within actions.
    """
    cell = np.char.add(np.char.add(recorded.action, "|"), recorded.person)
    return design([recorded.action, recorded.person], cell), design([recorded.action], cell)


def spreads(recorded):
    """All standard deviations."""
    constant, other = designs(recorded)
    mean = recorded.deviations.mean(axis=1)
    rest = recorded.deviations - mean[:, None]
    of_dof = {}
    for column, name in enumerate(DOFS):
        person, recording = components(mean[:, column], constant)
        at = np.square([components(rest[:, k, column], other) for k in range(len(PHASES))])
        person_key, recording_key = np.sqrt(at.mean(axis=0))
        key = name.removeprefix("left_").removeprefix("right_")
        of_dof.setdefault(key, []).append([person, person_key, recording, recording_key])
    execution = {key: Execution(*np.sqrt(np.mean(np.square(sides), axis=0))) for key, sides in of_dof.items()}
    return Spreads(execution, components(recorded.tempo, other), components(recorded.timing, other))


def report(recorded):
    """Print everything that is measured; return it."""
    found, (_, other) = spreads(recorded), designs(recorded)
    n_actions = len(set(recorded.action))
    print(f"{len(recorded.action)} recordings, {n_actions} actions, {len(set(recorded.person))} people; ", end="")
    print(f"{other.people} degrees of freedom between people, {sum(other.d == 0)} within")
    print("\nstandard deviations in an action, degrees: of a person, of one repetition; all the time, at each phase")
    print(f"{'dof':<16}{'person':>10}{'at phases':>11}{'repetition':>12}{'at phases':>11}")
    for key, one in found.execution.items():
        print(f"{key:<16}{one.person:10.1f}{one.person_key:11.1f}{one.recording:12.1f}{one.recording_key:11.1f}")
    median = np.median(list(found.execution.values()), axis=0)
    print(f"{'median':<16}{median[0]:10.1f}{median[1]:11.1f}{median[2]:12.1f}{median[3]:11.1f}")
    for name, (person, recording) in (("tempo", found.tempo), ("timing", found.timing)):
        print(f"{name + ', %':<16}{100 * person:10.1f}{'':11}{100 * recording:12.1f}")
    return found


def recognise(n_seeds):
    """Print how well the actions of some seeds are recognised, and under which metric best."""
    found = np.array([[row[1:6] for row in compare(prepare(make_actions(random_state=k)))] for k in range(n_seeds)])
    mean, deviation = 100 * found.mean(axis=0), 100 * found.std(axis=0, ddof=1)
    print(f"{n_seeds} seeds, %\n{'metric':<10}" + "".join(f"{name:>20}" for name in Result._fields[1:6]) + "  first")
    first = found[:, :, 0].argmax(axis=1)
    for k, metric in enumerate(COMPARED):
        cells = (f"{m:.1f} ± {d:.1f}" for m, d in zip(mean[k], deviation[k], strict=True))
        print(f"{metric:<10}" + "".join(f"{cell:>20}" for cell in cells) + f"{sum(first == k):>7}")


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--seeds", type=int, help="seeds whose actions are recognised")
    arguments.add_argument("folder", nargs="?", help="HDM05 files, see load_hdm05; default: generated actions")
    options = arguments.parse_args()
    if options.seeds:
        recognise(options.seeds)
        return
    if options.folder:
        report(recordings(on_feet(load_hdm05(options.folder))))
        return
    size = (2, 2, ["reach", "squat"]) if options.quick else (3, 6, None)
    actions = {} if size[2] is None else {"actions": size[2]}
    report(recordings(make_actions(*size[:2], **actions, random_state=0)))


if __name__ == "__main__":
    main()
