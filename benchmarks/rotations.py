"""Ball joints: how well do metrics classify actions, how fast are they, how long are geodesics? Against Euler angles.

    python benchmarks/rotations.py [FOLDER OF HDM05 FILES] [--cmu FOLDER OF CMU FILES] [--quick]

Actions: the nearest neighbour among the poses of other people, at 12 Hz, on the mean skeleton; for whole sequences by
dynamic time warping, the least sum of distances along a path of steps of one frame in either sequence or in both,
divided by the number of frames of the two. Speed: skeletons take turns, one thread. Without folders the motions are
generated gait, whose actions are walking and running.
"""

import tempfile
import warnings
from pathlib import Path
from typing import NamedTuple

import common
import numpy as np
from nearest import RATE, shares

from skpose import forward_kinematics, geodesic, pose_distances
from skpose._compiled.path.geodesic import MAX_ITER, TOL, path_between
from skpose._compiled.path.minimiser import Bounds
from skpose.datasets import MotionDataset, load_cmu, load_hdm05, make_gait
from skpose.io import load_amass
from skpose.kinematics._tree import to_tree_order, tree_of, wrap_dofs
from skpose.metrics import Angle
from skpose.skeleton._interpolation import interpolate_poses

N_STEPS, SEED = 10, 0
METRICS = {
    "angle, literal": {"metric": "angle"},
    "angle, wrapped": {"metric": Angle(wrap=True)},
    "position": {"metric": "position"},
    "rotation": {"metric": "rotation"},
    "spatial": {"metric": "spatial"},
}


class Size(NamedTuple):
    n_poses: int  # in each race
    n_pairs: int  # of geodesics
    repeats: int


FULL, QUICK = Size(1000, 200, 15), Size(40, 10, 1)


def actions(dataset):
    """The table of all metrics, Euler angles and ball joints, without the root, with its tilt, with all of it."""
    X, sequence = dataset.poses(RATE)
    print(f"\n{len(X)} poses of {len(dataset)} sequences, {len(set(dataset.subjects))} people, {RATE} Hz")
    print(f"{'share of frames / sequences, %':<34}" + "".join(f"{name:>18}" for name in METRICS))
    for root in (None, "tilt", "whole"):
        with_root = dataset if root is None else dataset.with_root(root)
        for joints in ("Euler", "ball"):
            # The root that is added is a ball joint; Euler angles for it too.
            motions = [m.to_rotvec() if joints == "ball" else m.to_euler("ZYX") for m in with_root]
            converted = MotionDataset(motions, dataset.subjects, dataset.trials, dataset.actions)
            X, sequence = converted.poses(RATE)
            cells = []
            for parameters in METRICS.values():
                given = {"skeleton": converted.skeleton, **parameters}
                found = shares(pose_distances(X, **given), X, sequence, dataset, **given)
                cells.append("{:.1f} / {:.1f}".format(*found))
            print(f"{joints + ', root: ' + (root or 'none'):<34}" + "".join(f"{cell:>18}" for cell in cells))


def speed(dataset, size):
    """Pairs a second of "spatial", of the same poses with Euler angles and with ball joints."""
    rng = np.random.default_rng(SEED)
    euler, ball = dataset, dataset.to_rotvec()
    rows = rng.choice(len(euler.poses()[0]), size.n_poses)
    chosen = {"Euler": (euler.poses()[0][rows], euler.skeleton), "ball": (ball.poses()[0][rows], ball.skeleton)}
    np.testing.assert_allclose(*(forward_kinematics(*poses) for poses in chosen.values()), atol=1e-9)
    for dtype in (np.float64, np.float32):
        contestants = {}
        for name, (X, skeleton) in chosen.items():
            X = X.astype(dtype)
            contestants[name] = lambda X=X, skeleton=skeleton: pose_distances(
                X, X.copy(), skeleton=skeleton, metric="spatial", n_jobs=1
            )
        seconds = common.medians(contestants, size.repeats)
        rates = ", ".join(f"{name} {size.n_poses**2 / s / 1e6:.2f} M pairs/s" for name, s in seconds.items())
        print(f"spatial, {np.dtype(dtype)}: {rates}; ball over Euler {seconds['Euler'] / seconds['ball']:.2f} ×")


def geodesics(dataset, size):
    """Random pairs: geodesics against both straight lines, and against those found from the line of the angles."""
    skeleton, rng = dataset.skeleton, np.random.default_rng(SEED)
    X, tree = dataset.poses(RATE)[0], tree_of(skeleton)
    pairs = rng.choice(len(X), (size.n_pairs, 2))
    found, lines, slerps, from_line = (np.empty(size.n_pairs) for _ in range(4))
    for k, (i, j) in enumerate(pairs):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # one that does not converge is as long as it is
            found[k], lines[k] = (
                pose_distances(X[[i]], X[[j]], skeleton=skeleton, metric=metric)[0, 0]
                for metric in ("geodesic", "spatial")
            )
        path = interpolate_poses(skeleton.bones, X[[i, j]], np.linspace(0, 1, N_STEPS + 1))
        positions = forward_kinematics(path, skeleton).reshape(N_STEPS + 1, -1)
        slerps[k] = np.linalg.norm(np.diff(positions, axis=0), axis=1).sum()
        start, end = to_tree_order(tree, X[i]), to_tree_order(tree, X[j])
        end, free = wrap_dofs(tree, end, start), np.full(len(start), np.inf)
        curve = path_between(tree, start, end, N_STEPS, False, Bounds(-free, free), MAX_ITER, TOL)
        from_line[k] = min(curve.length, lines[k])
    assert (found <= np.minimum(lines, slerps) * (1 + 1e-9)).all()
    gain = 1 - found / from_line
    shorter = gain > 1e-3
    print(f"\n{size.n_pairs} random pairs: no geodesic is longer than the line or the slerp")
    print(f"from the angles' line alone {(from_line > slerps * (1 + 1e-9)).sum()} are longer than the slerp")
    median = np.median(gain[shorter]) if shorter.any() else 0.0
    print(
        f"shorter than those by more than 0.1 %: {shorter.sum()}, by {100 * median:.1f} % in the median, "
        f"{100 * gain.max():.1f} % at most"
    )
    print(f"longer by more than 0.1 %: {(gain < -1e-3).sum()}, by {-100 * gain.min():.1f} % at most")


def hands(size):
    """A skeleton with hands, as SMPL-H has it: 52 joints, 156 columns."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that there is no model
        path = Path(folder, "still.npz")
        np.savez(path, poses=np.zeros((1, 156)), trans=np.zeros((1, 3)), betas=np.zeros(16), mocap_framerate=60.0)
        skeleton = load_amass(path).with_root("whole").skeleton
    X = np.random.default_rng(SEED).normal(scale=0.3, size=(size.n_poses, skeleton.n_dofs))
    print(f"\n{skeleton.n_joints} joints, {skeleton.n_dofs} columns, one thread")
    contestants = {
        metric: lambda metric=metric: pose_distances(X, X.copy(), skeleton=skeleton, metric=metric, n_jobs=1)
        for metric in ("angle", "position", "rotation", "spatial")
    }
    for metric, seconds in common.medians(contestants, size.repeats).items():
        print(f"{metric:<10}{1e6 * seconds / size.n_poses**2:>12.3f} µs a pair")
    few = X[:4]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        paths = {"geodesic": lambda: [geodesic(few[i], few[i + 1], skeleton) for i in range(3)]}
        seconds = common.medians(paths, 1 if size is QUICK else 3)["geodesic"] / 3
    print(f"{'geodesic':<10}{1e3 * seconds:>12.0f} ms")


def main():
    arguments = common.parser(__doc__)
    arguments.add_argument("--cmu", help="CMU files for the speed, see load_cmu; default: generated gait")
    options = arguments.parse_args()
    common.print_machine()
    size = QUICK if options.quick else FULL
    gait = make_gait(*((2, 2) if options.quick else (10, 10)), random_state=SEED)
    dataset = load_hdm05(options.folder) if options.folder else gait
    actions(dataset)
    speed(load_cmu(options.cmu) if options.cmu else gait, size)
    geodesics(dataset, size)
    hands(size)


if __name__ == "__main__":
    main()
