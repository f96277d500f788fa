"""In-betweening: how near are motions that are filled in between key poses to the frames that were left out?

    python benchmarks/in_betweening.py --cmu FOLDER --hdm05 FOLDER [--quick]

Of every sequence all but some frames are left out and filled in: nine of ten at the rate of the file, which is 83 ms
between keys at 120 Hz and 333 ms at 30 Hz, and then 14 of 15 at 30 Hz, keys half a second apart. Errors are those of
the joint positions, cm, the root held: the root of the mean square over joints and frames left out, up to the last key;
the median of the sequences, and over all their frames. Only the keys are known: columns are made continuous from them.

- linear Euler: each angle linearly, wrapped.
- cubic Euler: natural cubic splines of the angles.
- slerp: each joint by itself, what `Motion.resample` does with ball joints.
- RotationSpline: scipy's, of each joint by itself, of continuous angular velocity and acceleration.
- geodesic, spline: `skpose.geodesics.interpolate`.

Each table is followed by the number of sequences in which the spline is nearer than RotationSpline, and by the time.
Without folders: generated gait.
"""

import time

import common
import numpy as np
from joblib import Parallel, delayed
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import RotationSpline

from skpose import Motion, forward_kinematics
from skpose.datasets import load_cmu, load_hdm05, make_gait
from skpose.geodesics import interpolate
from skpose.skeleton._interpolation import interpolate_poses as joint_by_joint
from skpose.skeleton._rotations import columns_of, rotations_of

PROTOCOLS = {"nine of ten frames": (None, 10), "30 Hz, keys 0.5 s apart": (30, 15)}


def linear_euler(keys, times, at):
    keys = keys.unwrap().angles
    return np.stack([np.interp(at, times, column) for column in keys.T], axis=1)


def cubic_euler(keys, times, at):
    return CubicSpline(times, keys.unwrap().angles, bc_type="natural")(at)


def slerp(keys, times, at):
    return joint_by_joint(keys.skeleton.bones, keys.angles, np.interp(at, times, np.arange(len(times))))


def rotation_spline(keys, times, at):
    """Of joints with three dofs; other joints' angles have natural cubic splines."""
    poses, first = cubic_euler(keys, times, at), 0
    for bone in keys.skeleton.bones:
        columns = slice(first, first + bone.n_dofs)
        first += bone.n_dofs
        if bone.n_dofs == 3:
            spline = RotationSpline(times, rotations_of(bone, keys.angles[:, columns]))
            poses[:, columns] = columns_of(bone, spline(at), np.zeros(3))
    return poses


def on_manifold(method):
    def fill(keys, times, at):
        rate = 1.0 / (at[1] - at[0])
        return interpolate(keys.angles, times, keys.skeleton, frame_rate=rate, method=method).angles

    return fill


# Whether the joints are ball joints, and the method.
METHODS = {
    "linear Euler": (False, linear_euler),
    "cubic Euler": (False, cubic_euler),
    "slerp": (True, slerp),
    "RotationSpline": (True, rotation_spline),
    "geodesic": (False, on_manifold("geodesic")),
    "spline": (False, on_manifold("spline")),
}


def squared_errors(motion, every):
    """Sums of the squared errors of the frames left out, m², the number of positions, and the seconds of each method.

    One row for each method.
    """
    n_keys = (len(motion) - 1) // every + 1
    if n_keys < 3:
        return None
    last = (n_keys - 1) * every
    out = np.arange(last + 1) % every > 0
    truth = forward_kinematics(motion.angles[: last + 1], motion.skeleton)[out]
    at = np.arange(last + 1) / motion.frame_rate
    rows = []
    for is_ball, fill in METHODS.values():
        keys = Motion(motion.skeleton, motion.angles[: last + 1 : every], motion.frame_rate / every)
        keys = keys.to_rotvec() if is_ball else keys
        start = time.perf_counter()
        filled = fill(keys, at[::every], at)
        seconds = time.perf_counter() - start
        assert len(filled) == len(at)
        found = forward_kinematics(filled, keys.skeleton)
        on_keys = forward_kinematics(motion.angles[: last + 1 : every], motion.skeleton)
        assert np.abs(found[~out] - on_keys).max() < 1e-6  # m
        rows.append((np.square(found[out] - truth).sum(), truth.shape[0] * truth.shape[1], seconds))
    return np.array(rows)


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    datasets = {}
    if options.cmu:
        datasets["CMU"] = load_cmu(options.cmu)
    if options.hdm05:
        datasets["HDM05"] = load_hdm05(options.hdm05)
    if not datasets:
        datasets["generated gait"] = make_gait(2 if options.quick else 10, 1 if options.quick else 4, random_state=0)
    for name, dataset in datasets.items():
        last = 150 if options.quick else None
        motions = list(dataset.motions)[:: 40 if options.quick else 1]
        for protocol, (rate, every) in PROTOCOLS.items():
            start = time.perf_counter()
            found = Parallel(n_jobs=-1)(
                delayed(squared_errors)(motion.resample(rate or motion.frame_rate)[:last], every) for motion in motions
            )
            table = np.array([rows for rows in found if rows is not None])  # sequences, methods, sums
            errors = 100 * np.sqrt(table[:, :, 0] / table[:, :, 1])
            pooled = 100 * np.sqrt(table[:, :, 0].sum(axis=0) / table[:, :, 1].sum(axis=0))
            print(f"\n{name}, {protocol}: {len(table)} of {len(motions)} sequences\n")
            print("| | median, cm | all frames, cm | time of a frame, ms |\n|---|---|---|---|")
            n_frames = table[:, 0, 1].sum() / dataset.skeleton.n_joints
            for i, method in enumerate(METHODS):
                each = 1e3 * table[:, i, 2].sum() / n_frames
                print(f"| {method} | {np.median(errors[:, i]):.3g} | {pooled[i]:.3g} | {each:.2g} |")
            names = list(METHODS)
            nearer = errors[:, names.index("spline")] < errors[:, names.index("RotationSpline")]
            print(f"\nspline nearer than RotationSpline: {nearer.sum()} of {len(nearer)} sequences")
            print(f"{time.perf_counter() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
