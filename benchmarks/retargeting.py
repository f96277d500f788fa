"""Retargeting: how near does a motion of one person's file come to it on the skeleton of another person's file?

    python benchmarks/retargeting.py [--cmu FOLDER OF CMU FILES --hdm05 FOLDER OF HDM05 FILES] [--quick]

The first motion of each set at 6 Hz, on the skeleton of the first motion of the other, by each method, with
``scale="lengths"``. "Hinges" is the skeleton as it is, "balls" has ball joints only. Distances are those of the joints
in the world, the motion scaled; directions are those of the bones. Without folders the two are of generated gait.
"""

from dataclasses import replace

import common
import numpy as np
from scipy.spatial.transform import Rotation

from skpose import Skeleton, forward_kinematics
from skpose.datasets import load_cmu, load_hdm05, make_gait
from skpose.kinematics import retarget

METHODS = ("orientations", "positions", "numbers")


def world(motion):
    """Return positions of the root, and of the joints, in the world."""
    rotations = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    positions = np.einsum("nij,nkj->nki", rotations, forward_kinematics(motion.angles, motion.skeleton))
    return np.concatenate([positions, np.zeros((len(motion), 1, 3))], axis=1) + motion.root_positions[:, None]


def directions(motion, names):
    """Return the directions of the bones to the joints of these names; zero for bones without a length."""
    positions = world(motion)
    bones = positions[:, :-1] - positions[:, motion.skeleton.parents]  # the root is the last, parent -1
    lengths = np.linalg.norm(bones, axis=2, keepdims=True)
    units = np.where(lengths > 1e-3 * lengths.max(), bones / np.where(lengths > 0.0, lengths, 1.0), 0.0)
    return units[:, [motion.skeleton.joint_names.index(name) for name in names]]


def compare(label, motion, skeleton):
    """Print the distances of all methods."""
    balls = Skeleton(
        [b._replace(dofs="rotvec" if b.dofs else "", limits=None) for b in skeleton.bones], skeleton.offset_frame
    )
    names = skeleton.joint_names
    unit = replace(motion, root_positions=np.ones((len(motion), 3)))  # the scale is that of the root's positions too
    factor = retarget(unit, balls, method="orientations", scale="lengths").root_positions[0, 0]
    wished, toward = factor * world(motion), directions(motion, names)
    order = [motion.skeleton.joint_names.index(name) for name in names]
    for target, kind in ((skeleton, "hinges"), (balls, "balls")):
        for method in METHODS:
            try:
                found = retarget(motion, target, method=method, scale="lengths")
            except ValueError as error:
                print(f"{label:14} {kind:7} {method:13} refused: {str(error)[:70]}…")
                continue
            apart = 100.0 * np.linalg.norm(world(found)[:, :-1] - wished[:, order], axis=2)
            reached = directions(found, names)
            known = reached.any(axis=(0, 2)) & toward.any(axis=(0, 2))
            chords = np.linalg.norm(reached - toward, axis=2)[:, known]
            angles = np.degrees(2.0 * np.arcsin(np.minimum(chords / 2.0, 1.0)))
            print(
                f"{label:14} {kind:7} {method:13} joints {apart.mean():5.2f} cm, at most {apart.max():5.2f}; "
                f"directions {angles.mean():5.2f}°, at most {angles.max():6.2f}"
            )


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    if options.quick or not (options.cmu and options.hdm05):
        first, second = make_gait(n_subjects=2, n_sequences=1, random_state=0).motions[::2]
        sets = {"person 1": first, "person 2": second}
    else:
        sets = {"CMU": load_cmu(options.cmu)[0], "HDM05": load_hdm05(options.hdm05)[0]}
    (one, first), (two, second) = ((name, motion.resample(6)) for name, motion in sets.items())
    compare(f"{one} → {two}", first, second.skeleton)
    compare(f"{two} → {one}", second, first.skeleton)


if __name__ == "__main__":
    main()
