"""How well does each metric recognise actions of people who are not in the training data?

    python benchmarks/metrics.py [--hdm05 FOLDER] [--cmu FOLDER] [--quick]

1-nearest-neighbour accuracy, leave-one-person-out, at 12 Hz on the mean skeleton: of single frames, and of whole
sequences by dynamic time warping. Rows: Euler angles as in the files or ball joints, without the orientation of the
root, with its tilt, or with all of it. Without folders the motions are generated gait.
"""

import common
import numpy as np

from skpose import motion_distances, pose_distances
from skpose.datasets import MotionDataset
from skpose.metrics import Angle

RATE = 12  # Hz
METRICS = {"angle": "angle", "angle, wrapped": Angle(wrap=True)} | {
    name: name for name in ("position", "rotation", "spatial")
}


def accuracy(distances, labels, subjects):
    """1-NN accuracy among other people, in percent."""
    others = np.where(subjects[:, None] == subjects, np.inf, distances)
    return 100 * (labels[others.argmin(axis=1)] == labels).mean()


def converted(dataset, joints, root):
    """The dataset with Euler angles or ball joints, and a part of the root's orientation."""
    if root != "none":
        dataset = dataset.with_root(root)
    motions = [motion.to_rotvec() if joints == "ball" else motion.to_euler("ZYX") for motion in dataset]
    return MotionDataset(motions, dataset.subjects, dataset.trials, dataset.actions, rotations="file")


def table(name, dataset):
    """Print accuracies of frames / sequences."""
    print(f"\n{name}: {len(dataset)} sequences of {len(set(dataset.subjects))} people")
    print(f"{'frames / sequences, %':<24}" + "".join(f"{metric:>18}" for metric in METRICS))
    for root in ("none", "tilt", "whole"):
        for joints in ("Euler", "ball"):
            data = converted(dataset, joints, root)
            X, sequence = data.poses(RATE)
            sequences = np.split(X, np.searchsorted(sequence, np.arange(1, len(data))))
            cells = []
            for metric in METRICS.values():
                given = {"skeleton": data.skeleton, "metric": metric, "n_jobs": -1}
                of_frames = accuracy(pose_distances(X, **given), data.actions[sequence], data.subjects[sequence])
                of_sequences = accuracy(motion_distances(sequences, **given), data.actions, data.subjects)
                cells.append(f"{of_frames:.1f} / {of_sequences:.1f}")
            print(f"{joints + ', root: ' + root:<24}" + "".join(f"{cell:>18}" for cell in cells), flush=True)


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    for name, dataset in common.datasets(options).items():
        table(name, dataset[::4] if options.quick else dataset)


if __name__ == "__main__":
    main()
