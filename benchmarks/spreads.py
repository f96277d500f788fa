"""Spreads of posture: how do the mean joint angles of people differ, and those of one person's recordings?

    python benchmarks/spreads.py [FOLDER OF CMU FILES] [--hdm05 FOLDER OF HDM05 FILES] [--quick]

The figures from which `skpose.datasets.make_gait` draws its people, measured on the walks and runs of CMU and the jogs
of HDM05. Without folders it measures generated gait, and checks that it finds the figures that were drawn.

1. Every frame is put on the joints of `skpose.datasets.humanoid` (see `on_humanoid`), in degrees. The posture of a
   recording is the mean of each dof over whole cycles: the constant of a Fourier series, fitted to its frames.
2. y = mean of the group + effect of the person + effect of the recording. Groups are the walks and the runs of CMU and
   the jogs of HDM05; effects are normal. Restricted maximum likelihood (REML) gives the two standard deviations, so
   that the spread over people does not include the one over recordings.
3. A dof of the left and of the right is measured as half their sum and half their difference, mirrored: the part that
   a person's two sides share and the part in which they differ. Each has a spread of its own.
4. Correlations of people's effects by class: of the two sides; of a joint with the one before it, about the same axis;
   of the dofs of one joint. A class outside what independent people of the same spreads show (95 % of simulations) is
   drawn: the sides by 3., pairs of joints with their own correlation each.
5. The spreads of amplitude are those of the logarithm of a curve's root mean square over a cycle, the sides pooled; the
   spreads of phase those of its first harmonic, left minus right, after the hip's.

With eight people and two databases a spread over people has 6 degrees of freedom: the interval of 95 %, by the
chi-squared distribution, is from 0.64 to 2.2 times the figure. A correlation of independent dofs is within ±0.75.
"""

from itertools import permutations
from typing import NamedTuple

import common
import numpy as np
from scipy.linalg import null_space
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from skpose.datasets import humanoid, load_cmu, load_hdm05, make_gait, walks_and_runs
from skpose.datasets._curves import LIMB_DOFS
from skpose.datasets._humanoid import PARENTS
from skpose.datasets._spreads import POSTURE, STYLE, Spread, mirror
from skpose.skeleton._rotations import rotations_of

DOFS = humanoid().dof_names
LIMBS = [key for key in POSTURE if key not in DOFS]  # of the left and of the right
TRUNK = {
    "abdomen": ["lowerback"],
    "chest": ["upperback", "thorax"],
    "neck": ["lowerneck"],
    "head": ["upperneck", "head"],
}
# Own axes of CMU's humerus -> axes of the humanoid's hanging arm: the bone is its -y, and the elbow flexes about its x,
# where the humanoid's flexes about -x.
HANGING = Rotation.from_euler("y", 180, degrees=True)
HARMONICS = 3  # fitted to find phases; a jog of HDM05 has some fifty frames a cycle and two cycles
CADENCES = np.arange(0.5, 2.0, 0.005)  # Hz, tried
N_SIMULATIONS = 500
ONE, CHAIN = "dofs of one joint", "joint before, same axis"
STILL = 1e-6  # degrees; the clavicles of these files never move

# --- on one skeleton -------------------------------------------------------------------------------------------------


def on_humanoid(motion):
    """Angles (n_frames, 42) of a motion on the humanoid's joints, degrees, and those of dofs that it lacks, by name.

    CMU's and HDM05's files have the same joints and axes. Their trunk has the humanoid's axes; where the humanoid has
    one joint for two of theirs, it gets the product of the rotations. Arms and legs point elsewhere at angle zero,
    which changes the joints at their upper ends alone: femur and humerus. All other limb dofs are the same rotation
    about the same axis of the limb, up to the sign, with two exceptions: the second dof of their foot is about the
    axis of the shank, that of the humanoid's about z, along the foot, and gets its figure for want of another; wrist,
    fingers and thumb have no counterpart.
    """
    if motion.skeleton.dof_names == DOFS:
        return np.degrees(motion.angles), {}
    bones, ends = motion.skeleton.bones, np.cumsum([bone.n_dofs for bone in motion.skeleton.bones])
    columns = {b.name: motion.angles[:, end - b.n_dofs : end] for b, end in zip(bones, ends, strict=True)}
    rests = dict(zip(motion.skeleton.joint_names, motion.skeleton.rest_rotations, strict=True))
    turned = {
        b.name: Rotation.from_matrix(rests[b.name].copy()) * rotations_of(b, columns[b.name]) for b in bones if b.dofs
    }
    angle = {f"{b.name}_{axis}": columns[b.name][:, k] for b in bones for k, axis in enumerate(b.dofs)}
    found, others = {}, {}

    def three(name, rotation):
        found.update(zip((f"{name}_r{axis}" for axis in "xyz"), rotation.as_euler("xyz").T, strict=True))

    for name, (first, *rest) in TRUNK.items():
        rotation = turned[first]
        for joint in rest:
            rotation = rotation * turned[joint]
        three(name, rotation)
    for side, s, sign in (("left", "l", 1.0), ("right", "r", -1.0)):
        three(f"{side}_thigh", turned[f"{s}femur"])
        three(f"{side}_upper_arm", turned[f"{s}humerus"] * HANGING.inv())
        found |= {
            f"{side}_shank_rx": angle[f"{s}tibia_x"],
            f"{side}_foot_rx": angle[f"{s}foot_x"],
            f"{side}_foot_rz": angle[f"{s}foot_z"],  # about the axis of the shank, see above
            f"{side}_toes_rx": angle[f"{s}toes_x"],
            f"{side}_clavicle_ry": angle[f"{s}clavicle_y"],
            f"{side}_clavicle_rz": angle[f"{s}clavicle_z"],
            f"{side}_forearm_rx": -angle[f"{s}radius_x"],
            f"{side}_hand_rx": sign * angle[f"{s}hand_z"],  # the palm of a hanging arm faces the thigh
            f"{side}_hand_rz": -sign * angle[f"{s}hand_x"],
        }
        lacked = ("wrist_y", "fingers_x", "thumb_x", "thumb_z")
        others |= {f"{side}_{name}": np.degrees(angle[f"{s}{name}"]) for name in lacked}
    return np.degrees(np.stack([found[name] for name in DOFS], axis=1)), others


# --- variance components ---------------------------------------------------------------------------------------------


class Design(NamedTuple):
    """Recordings as rotated contrasts, free of the groups' means: of variance σ_e² + d σ_p² each, and independent."""

    contrasts: np.ndarray  # (n_contrasts, n_recordings)
    d: np.ndarray  # 0 for a contrast within people

    @property
    def people(self):
        """Degrees of freedom between people."""
        return int((self.d > 1e-9).sum())


def design(groups, people):
    """The design of a one-way model with random people, and with fixed groups."""
    X, Z = (
        np.equal.outer(labels, np.unique(labels)).astype(float) for labels in (np.asarray(groups), np.asarray(people))
    )
    K = null_space(X.T)
    d, U = np.linalg.eigh(K.T @ Z @ Z.T @ K)
    return Design((K @ U).T, np.where(d > 1e-9, d, 0.0))


def components(y, by):
    """Standard deviations over people and over recordings of one quantity (n_recordings,), by REML."""
    w = np.square(by.contrasts @ y)
    if np.sqrt(w.mean()) < STILL:
        return 0.0, 0.0

    def deviance(log_ratio):
        share = 1.0 + np.exp(log_ratio) * by.d
        return len(w) * np.log(np.mean(w / share)) + np.log(share).sum()

    grid = np.linspace(-12.0, 12.0, 97)
    best = grid[np.argmin([deviance(x) for x in grid])]
    best = minimize_scalar(deviance, bounds=(best - 0.25, best + 0.25), method="bounded", options={"xatol": 1e-9}).x
    ratio = 0.0 if best < -11.0 else np.exp(best)
    recording = np.mean(w / (1.0 + ratio * by.d))
    return float(np.sqrt(ratio * recording)), float(np.sqrt(recording))


def effects(Y, groups, people):
    """Least-squares effects of people (n_people, n_quantities), of sum zero in each database."""
    names = np.unique(people)
    X, Z = (
        np.equal.outer(labels, np.unique(labels)).astype(float) for labels in (np.asarray(groups), np.asarray(people))
    )
    found = np.linalg.lstsq(np.hstack([X, Z]), Y, rcond=None)[0][X.shape[1] :]
    base = np.array([name.split()[0] for name in names])
    for each in np.unique(base):
        found[base == each] -= found[base == each].mean(axis=0)
    return found


# --- recordings ------------------------------------------------------------------------------------------------------


class Recordings(NamedTuple):
    """Rows are recordings. Postures and others in degrees, amplitudes as logarithms, phases in cycles."""

    group: np.ndarray
    person: np.ndarray
    posture: np.ndarray  # (n, 42)
    others: dict  # of dofs that the humanoid lacks, (n,) each
    amplitude: np.ndarray  # (n, n_curves)
    phase: np.ndarray  # (n, n_curves)


def fourier(times, frequency):
    """The least-squares fit (2 HARMONICS + 1, n_frames) of a Fourier series: constant, cosines, sines."""
    angle = 2 * np.pi * frequency * times[:, None] * np.arange(1, HARMONICS + 1)
    return np.linalg.pinv(np.hstack([np.ones((len(times), 1)), np.cos(angle), np.sin(angle)]))


def cadence(times, signal):
    """The frequency, Hz, of the sine that fits a signal best."""

    def left(frequency):
        wave = np.exp(2j * np.pi * frequency * times)
        basis = np.stack([np.ones_like(times), wave.real, wave.imag], axis=1)
        return np.linalg.lstsq(basis, signal, rcond=None)[1].sum()

    return CADENCES[np.argmin([left(frequency) for frequency in CADENCES])]


def databases(cmu, hdm05):
    """The walks and runs of CMU and the jogs of HDM05, by the name of the database; None for one that is not there."""
    found = {}
    if cmu is not None:
        found["CMU"] = walks_and_runs(cmu)
    if hdm05 is not None:
        found["HDM05"] = hdm05[[action.startswith("jog") for action in hdm05.actions]]
    return found


def recordings(datasets):
    """Measure the recordings of datasets by name."""
    rows = [
        (name, m, s, a)
        for name, data in datasets.items()
        for m, s, a in zip(data, data.subjects, data.actions, strict=True)
    ]
    postures, others, amplitudes, phases = [], [], [], []
    for _, motion, _, _ in rows:
        angles, lacked = on_humanoid(motion)
        every = np.column_stack([angles, *lacked.values()])
        centre = np.degrees(np.angle(np.exp(1j * np.radians(every)).mean(axis=0)))
        around = (every - centre + 180) % 360 - 180
        dof = dict(zip((*DOFS, *lacked), around.T, strict=True))
        signals = {"hip_flexion": -dof["left_thigh_rx"] + dof["right_thigh_rx"]}
        times = motion.times - motion.times[0]
        fit = fourier(times, cadence(times, signals["hip_flexion"]))
        means = centre + fit[0] @ around
        postures.append(means[: len(DOFS)])
        others.append(dict(zip(lacked, means[len(DOFS) :], strict=True)))
        first, sizes = [], []
        for curve in STYLE:
            sides = sides_of(curve, dof)
            waves = [(fit[1 : HARMONICS + 1] - 1j * fit[HARMONICS + 1 :]) @ side for side in sides]
            first.append(waves[0][0] - (waves[1][0] if len(waves) > 1 else 0))  # half a cycle apart
            sizes.append(np.log(np.mean(np.square(np.abs(waves)).sum(axis=1))) / 2)
        amplitudes.append(sizes)
        phases.append(np.angle(np.array(first) / first[0]) / (2 * np.pi))
    around = np.exp(2j * np.pi * np.array(phases))
    centre = np.angle(around.mean(axis=0)) / (2 * np.pi)
    return Recordings(
        np.array([f"{name} {action}" for name, _, _, action in rows]),
        np.array([f"{name} {person}" for name, _, person, _ in rows]),
        level(np.array(postures)),
        {name: level(np.array([row[name] for row in others])[:, None])[:, 0] for name in others[0]},
        np.array(amplitudes),
        np.angle(around / np.exp(2j * np.pi * centre)) / (2 * np.pi) + centre,
    )


def level(postures):
    """Postures, degrees, each within half a turn of the circular mean of all recordings."""
    centre = np.degrees(np.angle(np.exp(1j * np.radians(postures)).mean(axis=0)))
    return centre + (postures - centre + 180) % 360 - 180


def sides_of(curve, dof):
    """The curve of the left and of the right side, or of the trunk."""
    if curve in LIMB_DOFS:
        name, sign, mirrored = LIMB_DOFS[curve]
        return [sign * dof[f"left_{name}"], (-sign if mirrored else sign) * dof[f"right_{name}"]]
    return [dof["abdomen_ry"] + dof["chest_ry"]]


# --- spreads ---------------------------------------------------------------------------------------------------------


def quantities(recorded):
    """The postures (n, 42) as what is measured: dofs of the trunk, of limbs what the sides share and differ in."""
    column = dict(zip(DOFS, recorded.posture.T, strict=True))
    shared, apart = {}, {}
    for key in POSTURE:
        if key in column:
            shared[key] = column[key]
        else:
            left, right = column[f"left_{key}"], mirror(key) * column[f"right_{key}"]
            shared[key], apart[key] = (left + right) / 2, (left - right) / 2
    return shared, apart


def spreads(recorded, by):
    """The `Spread` of every dof of the humanoid."""
    shared, apart = quantities(recorded)
    r = [with_parent(part, recorded.group, recorded.person) for part in (shared, apart)]
    found = {}
    for key in POSTURE:
        people, recording = components(shared[key], by)
        difference, other = components(apart[key], by) if key in apart else (0.0, 0.0)
        both = float(np.hypot(recording, other))  # of one side, the sum or the difference of the parts
        found[key] = Spread(people, difference, both, *(of.get(key, 0.0) for of in r))
    return found


def styles(recorded, by):
    """The spreads over people of each curve's amplitude, relative, and of its phase, cycles."""
    columns = zip(STYLE, recorded.amplitude.T, recorded.phase.T, strict=True)
    return {curve: tuple(components(y, by)[0] for y in pair) for curve, *pair in columns}


def interval(spread, by):
    """The interval of 95 % of a spread over people; the degrees of freedom of two parts are Satterthwaite's."""
    parts = np.square([spread.shared, spread.apart])
    df = by.people * parts.sum() ** 2 / np.square(parts).sum() if parts.any() else by.people
    return spread.people * np.sqrt(df / chi2.ppf([0.975, 0.025], df))


# --- correlations ----------------------------------------------------------------------------------------------------


def pairs_of_dofs():
    """Pairs of dofs by class: of one joint; of a joint and the one before it, about the same axis."""
    pairs = list(permutations(POSTURE, 2))
    return {
        ONE: [(a, b) for a, b in pairs if a < b and a[:-3] == b[:-3]],
        CHAIN: [(a, b) for a, b in pairs if PARENTS[b[:-3]] == a[:-3] and a[-1] == b[-1]],
    }


def moving_effects(columns, groups, people):
    """The effects of people (n_people,) on each quantity that moves."""
    moving = {key: y for key, y in columns.items() if np.ptp(y) > STILL}
    return dict(zip(moving, effects(np.stack([*moving.values()], axis=1), groups, people).T, strict=True))


def with_parent(columns, groups, people):
    """The correlation of people's effects on a dof with those on the joint before it, about the same axis."""
    effect = moving_effects(columns, groups, people)
    return {b: cosine(effect[a], effect[b]) for a, b in pairs_of_dofs()[CHAIN] if a in effect and b in effect}


def correlations(shared, apart, groups, people):
    """For each class of pairs: mean and root mean square of the correlation of people's effects; of the two sides."""
    parts = [moving_effects(columns, groups, people) for columns in (shared, apart)]
    found = {}
    for name, pairs in pairs_of_dofs().items():
        found[name] = [cosine(of[a], of[b]) for of in parts for a, b in pairs if a in of and b in of]
    both = np.array([[of[key] @ of[key] for of in parts] for key in parts[1]])
    found["left and right"] = (both[:, 0] - both[:, 1]) / both.sum(axis=1)
    return {name: (np.mean(r), np.sqrt(np.mean(np.square(r)))) for name, r in found.items()}


def cosine(a, b):
    """The correlation of effects of people, whose mean is zero."""
    return float(a @ b / np.sqrt((a @ a) * (b @ b)))


def independent(found, groups, people, rng):
    """The correlations of simulated people whose dofs, and sides, are independent, with the same spreads."""
    simulated = []
    number = np.unique(people, return_inverse=True)[1]

    def draw(spread):
        return spread.people * rng.normal(size=number.max() + 1)[number] + spread.recording * rng.normal(
            size=len(number)
        )

    for _ in range(N_SIMULATIONS):
        shared, apart = {}, {}
        for key, spread in found.items():
            if key in LIMBS:
                left, right = draw(spread), draw(spread)
                shared[key], apart[key] = (left + right) / 2, (left - right) / 2
            else:
                shared[key] = draw(spread)
        simulated.append(correlations(shared, apart, groups, people))
    return simulated


# --- the report ------------------------------------------------------------------------------------------------------


def report(recorded, seed=0):
    """Print everything that is measured; return the spreads and the styles."""
    by = design(recorded.group, recorded.person)
    names, counts = np.unique(recorded.group, return_counts=True)
    print(", ".join(f"{count} × {name}" for name, count in zip(names, counts, strict=True)), end="; ")
    print(f"{len(set(recorded.person))} people, {by.people} degrees of freedom between them, {sum(by.d == 0)} within")
    found = spreads(recorded, by)
    print("\nstandard deviations, degrees; r: correlations of people with the same axis of the joint before")
    print(f"{'dof':<14}{'shared':>8}{'r':>7}{'apart':>8}{'r':>7}{'people':>9}{'95 %':>14}{'recordings':>12}")
    for key, spread in found.items():
        parts = ((spread.shared, spread.shared_r), (spread.apart, spread.apart_r))[: 1 + (key in LIMBS)]
        cells = "".join(f"{size:8.1f}" + (f"{r:7.2f}" if r else " " * 7) for size, r in parts)
        low, high = interval(spread, by)
        print(f"{key:<14}{cells:<30}{spread.people:9.1f}{low:8.1f} –{high:4.1f}{spread.recording:12.1f}")
    people = [spread.people for spread in found.values()]
    print(f"{'median':<44}{np.median(people):9.1f}{np.median([s.recording for s in found.values()]):26.1f}")
    for name, column in recorded.others.items():
        sizes = components(column, by)
        print(f"{name + ', not on the humanoid':<44}{sizes[0]:9.1f}{sizes[1]:26.1f}")

    style = styles(recorded, by)
    print(f"\n{'curve':<22}{'amplitude, %':>14}{'phase, % of a cycle':>22}")
    for curve, (amplitude, phase) in style.items():
        print(f"{curve:<22}{100 * amplitude:14.0f}{100 * phase:22.1f}")

    shared, apart = quantities(recorded)
    observed = correlations(shared, apart, recorded.group, recorded.person)
    simulated = independent(found, recorded.group, recorded.person, np.random.default_rng(seed))
    print(f"\ncorrelations of people\n{'':<26}{'mean':>7}{'independent':>18}{'rms':>8}{'independent':>16}")
    for name, values in observed.items():
        bands = [np.quantile([s[name][k] for s in simulated], [0.025, 0.975]) for k in (0, 1)]
        cells = [f"{v:8.2f}{low:8.2f} to {high:5.2f}" for v, (low, high) in zip(values, bands, strict=True)]
        print(f"{name:<26}" + "".join(cells))
    return found, style


def check(found, style, by, n_recordings):
    """Compare what is measured on generated gait with what was drawn; each person is recorded n times."""

    def holds(measured, drawn, df, error=0.0):
        low, high = chi2.ppf([1e-5, 1 - 1e-5], df) / df
        return low * (drawn**2 + error) <= measured**2 + error <= high * (drawn**2 + error)

    within = int((by.d == 0).sum())
    for key, drawn in POSTURE.items():
        if not drawn.recording:
            continue  # the clavicles, which only sway
        parts = ("shared", "apart") if key in LIMBS else ("shared",)
        error = drawn.recording**2 / len(parts) / n_recordings  # of a person's mean
        assert all(holds(getattr(found[key], part), getattr(drawn, part), by.people, error) for part in parts), key
        assert holds(found[key].recording, drawn.recording, within), key
    for curve, drawn in STYLE.items():
        assert all(holds(*pair, by.people, 1e-5) for pair in zip(style[curve], drawn, strict=True)), curve


def main():
    arguments = common.parser(__doc__)
    arguments.add_argument("--hdm05", help="HDM05 files, see load_hdm05, whose jogs are measured too")
    options = arguments.parse_args()
    folders = (load_cmu, options.folder), (load_hdm05, options.hdm05)
    datasets = databases(*(load(folder) if folder else None for load, folder in folders))
    if datasets:
        report(recordings(datasets))
        return
    size = (8, 3) if options.quick else (60, 10)
    recorded = recordings({"generated": make_gait(*size, random_state=0)})
    check(*report(recorded), design(recorded.group, recorded.person), 2 * size[1])
    print("\nAs drawn.")


if __name__ == "__main__":
    main()
