"""Weights of joints: how well do they make distances recognise actions, and how much time do they take?

    python benchmarks/weights.py [FOLDER OF HDM05 FILES] [--quick]

Actions: the nearest neighbour among the poses of other people, as in `rotations.py`, on the mean skeleton of ball
joints. Fifteen rigid joints on each hand, five fingers of three bones, move only with the hand, as those of a file with
fingers that were not recorded. Speed: skeletons take turns, one thread. Without a folder motions are generated gait,
whose actions are walking and running.
"""

import re
from typing import NamedTuple

import common
import numpy as np
from nearest import RATE, shares

from skpose import Bone, pose_distances
from skpose.datasets import load_hdm05, make_gait

SEED = 0
METRICS = ("position", "rotation", "spatial")
EQUAL, LEFT_OUT = "equal", "hands and feet left out"
ADDED, ADDED_LEFT_OUT = "15 joints added to each hand", "the same, of weight 0"
N_FINGERS, N_PHALANGES, PHALANX, SPREAD = 5, 3, 0.03, 0.2  # lengths in m; SPREAD is the tangent between two fingers


class Size(NamedTuple):
    n_poses: int  # in the race
    repeats: int


FULL, QUICK = Size(1000, 15), Size(40, 1)


def with_fingers(skeleton):
    """The skeleton with five stretched fingers of three rigid bones at each hand, and the names of their joints."""
    bones = list(skeleton.bones)
    for name, offset in zip(skeleton.joint_names, skeleton.offsets, strict=True):
        if not re.search("hand$", name):
            continue
        ahead = offset / np.linalg.norm(offset)
        across = np.cross(ahead, np.eye(3)[np.abs(ahead).argmin()])
        for finger in range(N_FINGERS):
            direction = ahead + (finger - N_FINGERS // 2) * SPREAD * across / np.linalg.norm(across)
            parent = name
            for phalanx in range(N_PHALANGES):
                joint = f"{name}_{finger}_{phalanx}"
                bones.append(Bone(joint, parent, PHALANX * direction / np.linalg.norm(direction)))
                parent = joint
    added = [bone.name for bone in bones[skeleton.n_joints :]]
    return type(skeleton)(bones, skeleton.offset_frame), added


def weighted(skeleton):
    """Skeletons by the names of the rows; all have the same dofs."""
    ends = [name for name in skeleton.joint_names if re.search("hand|finger|thumb|foot|toe", name)]
    fingers, added = with_fingers(skeleton)
    return {
        EQUAL: skeleton,
        '"mass"': skeleton.with_weights("mass"),
        LEFT_OUT: skeleton.with_weights(dict.fromkeys(ends, 0)),
        ADDED: fingers,
        ADDED_LEFT_OUT: fingers.with_weights(dict.fromkeys(added, 0)),
    }


def actions(dataset):
    """The table of weights and metrics, without the root and with its tilt."""
    n_poses = len(dataset.poses(RATE)[0])
    print(f"\n{n_poses} poses of {len(dataset)} sequences, {len(set(dataset.subjects))} people, {RATE} Hz")
    print(f"{'share of frames / sequences, %':<38}" + "".join(f"{name:>18}" for name in METRICS))
    for title, converted in {"": dataset.to_rotvec(), ", tilt": dataset.with_root("tilt").to_rotvec()}.items():
        X, sequence = converted.poses(RATE)
        cells = dict.fromkeys(weighted(converted.skeleton), "")
        for metric in METRICS:
            squares, plain = {}, None
            for name, skeleton in weighted(converted.skeleton).items():
                given = {"skeleton": skeleton, "metric": metric}
                distances = pose_distances(X, n_jobs=-1, **given)
                found = shares(distances, X, sequence, dataset, **given)
                cells[name] += "{:>18}".format("{:.1f} / {:.1f}".format(*found))
                squares[name] = np.square(distances).mean()
                plain = distances if plain is None else plain
                if name == ADDED_LEFT_OUT:
                    np.testing.assert_array_equal(distances, plain)
            if metric == "position":
                added = 100 * (1 - squares[EQUAL] / squares[ADDED])
        for name, row in cells.items():
            print(f"{name + title:<38}{row}")
        print(f"the joints added are {added:.0f} % of the mean squared distance of positions{title}")


def speed(dataset, size):
    """Times of "spatial" of the same poses, with weights and without, and with an arm left out or dropped."""
    skeleton, rng = dataset.skeleton, np.random.default_rng(SEED)
    X = rng.permutation(dataset.poses()[0])[: size.n_poses]
    arm = next(name for name in skeleton.joint_names if re.match("l.*clavicle", name))
    part = skeleton.select(drop=arm)
    unseen = skeleton.with_weights(dict.fromkeys(set(skeleton.joint_names) - set(part.joint_names), 0))
    columns = np.ascontiguousarray(X[:, part.columns_in(skeleton)])
    contestants = {
        "equal weights": (X, skeleton),
        "all weights different": (X, skeleton.with_weights(np.linspace(0.5, 1.5, skeleton.n_joints))),
        '"mass"': (X, skeleton.with_weights("mass")),
        f"{arm} and beyond of weight 0": (X, unseen),
        f"{arm} and beyond dropped": (columns, part),
    }

    def measure(poses, skeleton):
        return pose_distances(poses, poses.copy(), skeleton=skeleton, metric="spatial", n_jobs=1)

    np.testing.assert_array_equal(measure(X, unseen), measure(columns, part))
    seconds = common.medians(
        {name: lambda given=given: measure(*given) for name, given in contestants.items()}, size.repeats
    )
    print(f"\nspatial, {len(X)} x {len(X)} poses, {skeleton.n_joints} ball joints and hinges, one thread, medians")
    for name, value in seconds.items():
        print(f"{name:<38}{1e3 * value:>10.1f} ms{value / seconds['equal weights']:>10.2f} x equal weights")


def main():
    options = common.start(__doc__)
    n = 2 if options.quick else 10  # people, and sequences of each
    dataset = load_hdm05(options.folder) if options.folder else make_gait(n, n, random_state=SEED)
    actions(dataset)
    speed(dataset.to_rotvec(), QUICK if options.quick else FULL)


if __name__ == "__main__":
    main()
