"""Keypoints with noise and gaps: what do skeletons and poses that are fitted to them differ from the truth?

    python benchmarks/keypoints.py [FOLDER OF HDM05 FILES] [--cmu FOLDER OF CMU FILES] [--quick]

Points are those of COCO's 17 that the motions have, at 30 Hz, with normal noise of 1 cm in each coordinate; 20 % of
them are missing at random. HDM05 has no eyes and ears, and the top of its head stands for the nose: 13 points. First
the poses on the person's own skeleton, of ball joints, that is known: how far are joints from the truth that are not
observed? Then everything from keypoints alone, with a skeleton that is fitted to them: does the nearest neighbour among
other people do the same, as in `rotations.py`? Lengths of bones from all joints, and input that is wrong, come first.
Without folders motions are generated gait.
"""

import warnings

import common
import numpy as np
from nearest import RATE, shares
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics, inverse_kinematics, pose_distances
from skpose.datasets import MotionDataset, load_cmu, load_hdm05, make_gait
from skpose.keypoints import Keypoints, fit_skeleton, layouts

SEED, NOISE, MISSING = 0, 0.01, 0.2  # NOISE in m
FRAME_RATE = 30  # Hz
REGULARIZATIONS = (0.0, 0.003, 0.01, 0.03)  # m/rad
INTERPOLATED = "0.01, gaps interpolated"  # of positions, linearly in time, before the fit
OF_KEYPOINTS = 0.01  # m/rad, on fitted skeletons
METRICS = ("position", "rotation", "spatial")
WITHIN = 0.01  # of a bone's length
# The joint of HDM05, and that of generated gait, for each point.
JOINTS = {
    "nose": ("head", "head"),
    "left_shoulder": ("lclavicle", "left_clavicle"),
    "right_shoulder": ("rclavicle", "right_clavicle"),
    "left_elbow": ("lhumerus", "left_upper_arm"),
    "right_elbow": ("rhumerus", "right_upper_arm"),
    "left_wrist": ("lwrist", "left_forearm"),
    "right_wrist": ("rwrist", "right_forearm"),
    "left_hip": ("lhipjoint", "left_pelvis"),
    "right_hip": ("rhipjoint", "right_pelvis"),
    "left_knee": ("lfemur", "left_thigh"),
    "right_knee": ("rfemur", "right_thigh"),
    "left_ankle": ("ltibia", "left_shank"),
    "right_ankle": ("rtibia", "right_shank"),
}
LAYOUT = layouts["coco17"].without([name for name in layouts["coco17"].names if name not in JOINTS])


def in_world(poses, skeleton, rotations, origins):
    """Return positions (n_frames, n_joints, 3) in the world, from the definition."""
    return np.einsum("nij,nkj->nki", rotations.as_matrix(), forward_kinematics(poses, skeleton)) + origins[:, None]


def world(motion):
    rotations = Rotation.from_euler(motion.root_axes, motion.root_angles)
    return in_world(motion.angles, motion.skeleton, rotations, motion.root_positions)


def people(dataset):
    """Yield the indices of the motions of each person."""
    for subject in dict.fromkeys(dataset.subjects):
        yield np.flatnonzero(dataset.subjects == subject)


def observed(skeleton):
    """Return the indices of the joints that stand for the points of the layout, in its order."""
    names = skeleton.joint_names
    return [names.index(next(joint for joint in JOINTS[point] if joint in names)) for point in LAYOUT.names]


def with_errors(positions, rng):
    """Return positions with noise and gaps."""
    noisy = positions + NOISE * rng.normal(size=positions.shape)
    noisy[rng.random(positions.shape[:2]) < MISSING] = np.nan
    return noisy


def interpolated(positions, lengths):
    """Return positions with all gaps inside each sequence closed, linearly in time."""
    filled, first = positions.copy(), 0
    for n in lengths:
        part = filled[first : first + n]
        for column in part.reshape(n, -1).T:
            seen = np.flatnonzero(~np.isnan(column))
            if len(seen):
                column[:] = np.interp(np.arange(n), seen, column[seen])
        first += n
    return filled


def quartet(distances):
    """Return mean, root mean square, median and 95 % of distances in cm."""
    d = 100 * distances
    return f"{d.mean():.2f} / {np.sqrt(np.square(d).mean()):.2f} / {np.median(d):.2f} / {np.quantile(d, 0.95):.2f}"


def unobserved(dataset):
    """Print the errors of joints on the people's own skeletons of ball joints."""
    print("\nerrors of joints, cm: mean / root mean square / median / 95 %")
    print(f"{'regularization, m/rad':<24}{'seen':>30}{'missing in the frame':>30}{'never seen':>30}")
    chosen = observed(dataset[0].skeleton)
    never = [j for j in range(dataset[0].skeleton.n_joints) if j not in chosen]
    names = dataset[0].skeleton.joint_names
    by_joint = {}
    for row in (*REGULARIZATIONS, INTERPOLATED):
        regularization = OF_KEYPOINTS if row is INTERPOLATED else row
        rng, errors, left = np.random.default_rng(SEED), [[], [], []], 0
        per_joint = []
        for indices in people(dataset):
            motions = [dataset[i] for i in indices]
            truth = np.concatenate([world(motion) for motion in motions])
            given = np.full(truth.shape, np.nan)
            given[:, chosen] = with_errors(truth[:, chosen], rng)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # not converged: counted
                fitted = inverse_kinematics(
                    interpolated(given, list(map(len, motions))) if row is INTERPOLATED else given,
                    motions[0].skeleton,
                    lengths=[len(motion) for motion in motions],
                    regularization=regularization,
                    n_jobs=-1,
                )
            left += (~fitted.converged).sum()
            rotations = Rotation.from_rotvec(fitted.root_rotations)
            off = in_world(fitted.poses, fitted.skeleton, rotations, fitted.root_positions) - truth
            off, seen = np.linalg.norm(off, axis=2), ~np.isnan(given[:, :, 0])
            gaps = ~seen
            gaps[:, never] = False
            for part, error in zip((seen, gaps), errors, strict=False):
                error.append(off[part])
            errors[2].append(off[:, never].ravel())
            per_joint.append(off[:, never])
        by_joint[row] = np.concatenate(per_joint).mean(axis=0)
        if row is not INTERPOLATED:  # the fit is nearer to the truth than what it is given
            assert np.square(np.concatenate(errors[0])).mean() < 3 * NOISE**2
        cells = "".join(f"{quartet(np.concatenate(error)):>30}" for error in errors)
        print(f"{row:<24}{cells}  {left} frames not converged")
    print("never seen, mean of each joint, cm, by regularization:")
    for k, j in enumerate(never):
        print(f"    {names[j]:<20}" + "".join(f"{100 * mean[k]:>8.2f}" for mean in by_joint.values()))


def from_keypoints(dataset, rng, closes_gaps=False):
    """Return the dataset as it is found from keypoints alone, with errors unless there is no generator of them."""
    motions = [None] * len(dataset)
    for indices in people(dataset):
        lengths = [len(dataset[i]) for i in indices]
        positions = np.concatenate([world(dataset[i])[:, observed(dataset[i].skeleton)] for i in indices])
        if rng is not None:
            positions = with_errors(positions, rng)
        if closes_gaps:
            positions = interpolated(positions, lengths)
        seen = LAYOUT.keypoints(positions, FRAME_RATE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the back bends; not converged
            skeleton = fit_skeleton(seen, LAYOUT)
            fitted = inverse_kinematics(
                seen, skeleton, lengths=lengths, regularization=OF_KEYPOINTS if rng is not None else 0.0, n_jobs=-1
            )
        motion, first = fitted.to_motion(FRAME_RATE), 0
        for i, n in zip(indices, lengths, strict=True):
            motions[i] = motion[first : first + n]
            first += n
    return MotionDataset(motions, dataset.subjects, dataset.trials, dataset.actions)


def actions(dataset):
    """Print how well actions are recognised, from true angles and from keypoints."""
    parts = observed(dataset[0].skeleton)
    names = dataset[0].skeleton.joint_names
    others = dict.fromkeys([name for j, name in enumerate(names) if j not in parts], 0)
    kinds = {
        "true angles": (dataset, None),
        "true angles, the points alone": (dataset, others),
        "keypoints, exact": (from_keypoints(dataset, None), None),
        "keypoints, noise and gaps": (from_keypoints(dataset, np.random.default_rng(SEED)), None),
        "keypoints, noise, gaps interpolated": (from_keypoints(dataset, np.random.default_rng(SEED), True), None),
    }
    print(f"\n{'share of frames / sequences, %':<44}" + "".join(f"{name:>18}" for name in METRICS))
    for title, (motions, without) in kinds.items():
        for tilt in ("", ", tilt"):
            X, sequence = (motions.with_root("tilt") if tilt else motions).poses(RATE)
            skeleton = (motions.with_root("tilt") if tilt else motions).skeleton
            skeleton = skeleton.with_weights(without) if without else skeleton
            cells = []
            for metric in METRICS:
                given = {"skeleton": skeleton, "metric": metric}
                distances = pose_distances(X, n_jobs=-1, **given)
                cells.append("{:.1f} / {:.1f}".format(*shares(distances, X, sequence, dataset, **given)))
            print(f"{title + tilt:<44}" + "".join(f"{cell:>18}" for cell in cells))


def all_joints(motions):
    """Return keypoints of the root and all joints."""
    positions = np.concatenate([world(motion) for motion in motions])
    roots = np.concatenate([motion.root_positions for motion in motions])
    names = ("root", *motions[0].skeleton.joint_names)
    return Keypoints(np.concatenate([roots[:, None], positions], axis=1), names, motions[0].frame_rate)


def lengths_of_bones(title, dataset):
    """Print how near the lengths of a fitted skeleton come to those of the files."""
    rng, off, lengths, people_of = np.random.default_rng(SEED), [], [], []
    for indices in people(dataset):
        motions = [dataset[i] for i in indices]
        true = motions[0].skeleton
        exact = all_joints(motions)
        noisy = Keypoints(
            exact.positions + NOISE * rng.normal(size=exact.positions.shape), exact.names, exact.frame_rate
        )
        layout = layouts["cmu31"]
        if "ltibia" not in exact.names:
            layout = LAYOUT
            noisy = LAYOUT.keypoints(noisy.positions[:, 1 + np.array(observed(true))], exact.frame_rate)
            exact = LAYOUT.keypoints(exact.positions[:, 1 + np.array(observed(true))], exact.frame_rate)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            expected, found = (
                np.linalg.norm(fit_skeleton(points, layout).offsets, axis=1) for points in (exact, noisy)
            )
        if layout is not LAYOUT:
            by_name = dict(zip(true.joint_names, np.linalg.norm(true.offsets, axis=1), strict=True))
            names = fit_skeleton(exact, layout).joint_names
            np.testing.assert_allclose(expected, [by_name.get(name, 0.0) for name in names], rtol=1e-3, atol=1e-9)
        bones = expected > 0.0
        off.append(np.abs(found / np.where(bones, expected, 1.0) - 1)[bones])
        lengths.append(expected[bones])
        people_of.append(f"{len(exact)} frames, worst {100 * off[-1].max():.2f} %")
    off, lengths = np.concatenate(off), np.concatenate(lengths)
    print(f"{title}: {'; '.join(people_of)}")
    for least in (0.0, 0.05, 0.1):
        kept = lengths >= least
        errors, worst = 100 * off[kept], lengths[kept][off[kept].argmax()]
        print(
            f"    {kept.sum()} bones of {100 * least:g} cm and more: median {np.median(errors):.3f} %, worst "
            f"{errors.max():.2f} % (a bone of {100 * worst:.1f} cm), within 1 %: {(off[kept] < WITHIN).sum()}"
        )


def outcome(title, function):
    """Print the warning or the error that wrong input gives."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            function()
            words = "no warning"
        except ValueError as error:
            words = f"ValueError: {error}"
    if caught:
        words = f"{caught[0].category.__name__}: {caught[0].message}"
    print(f"  {title:<28}{words[:150]}{'…' if len(words) > 150 else ''}")


def wrong_input(dataset):
    """Print what comes of data that are wrong in one respect."""
    rng = np.random.default_rng(SEED)
    motions = [dataset[i] for i in next(people(dataset))][:20]
    positions = np.concatenate([world(motion)[:, observed(motion.skeleton)] for motion in motions])
    positions += 0.001 * rng.normal(size=positions.shape)
    n = len(positions)
    stretched = positions.copy()
    elbow, wrist = (LAYOUT.names.index(name) for name in ("left_elbow", "left_wrist"))
    change = 1 + 0.3 * np.sin(np.linspace(0, 20, n))[:, None]
    stretched[:, wrist] = positions[:, elbow] + change * (positions[:, wrist] - positions[:, elbow])
    line = np.zeros_like(positions)
    line[:, :, 1] = np.linspace(0, 1.8, positions.shape[1])
    unseen = positions.copy()
    unseen[: n // 2] = np.nan
    cases = {
        "as it should be": positions,
        "a forearm stretches by 30 %": stretched,
        "all points on one line": line,
        "a single frame": positions[:1],
        "NaN in half of the frames": unseen,
        "NaN in all frames": np.full_like(positions, np.nan),
        "never an elbow": np.where(np.arange(positions.shape[1])[:, None] == elbow, np.nan, positions),
        "millimetres": 1000 * positions,
        "centimetres": 100 * positions,
        "two coordinates": positions[:, :, :2],
    }
    print("\nfit_skeleton, the first warning or error:")
    for title, given in cases.items():
        outcome(title, lambda given=given: fit_skeleton(given, LAYOUT))
    skeleton = fit_skeleton(positions, LAYOUT)
    print("inverse_kinematics:")
    for title in ("NaN in half of the frames", "NaN in all frames", "millimetres", "two coordinates"):
        given = cases[title] if title == "two coordinates" else LAYOUT.keypoints(cases[title], FRAME_RATE)
        outcome(title, lambda given=given: inverse_kinematics(given, skeleton))


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("folder", nargs="?", help="HDM05 files, see load_hdm05")
    arguments.add_argument("--cmu", help="CMU files for the lengths of bones, see load_cmu")
    options = arguments.parse_args()
    common.print_machine()
    n = 2 if options.quick else 5
    dataset = load_hdm05(options.folder) if options.folder else make_gait(n, n, random_state=SEED)
    print(f"\nlengths of bones, noise of {NOISE:g} m")
    lengths_of_bones("HDM05" if options.folder else "generated gait", dataset)
    if options.cmu:
        lengths_of_bones("CMU", load_cmu(options.cmu))
    wrong_input(dataset)
    motions = [motion[:: round(motion.frame_rate / FRAME_RATE)].to_rotvec() for motion in dataset]
    dataset = MotionDataset(motions, dataset.subjects, dataset.trials, dataset.actions)
    n_frames = sum(map(len, motions))
    print(f"\n{dataset}, {FRAME_RATE} Hz, {n_frames} frames; {len(LAYOUT.names)} points, {', '.join(LAYOUT.names)}")
    unobserved(dataset)
    actions(dataset)


if __name__ == "__main__":
    main()
