"""Joint angles: against those of OpenSim's inverse kinematics for the same markers, and against the norm of walking.

    python benchmarks/joint_angles.py [FOLDER OF MARKERS AND ANGLES] [--cmu FOLDER OF CMU FILES] [--quick]

The folder has recordings of one person: a standing one whose name begins with "static", and others, each as markers
(NAME.trc) and with OpenSim's angles (NAME_ik.mot). One skeleton is fitted to the standing recording, poses to the
markers of each other one; zero is the standing recording. Printed is, for each angle, the correlation with OpenSim's,
the standard deviation of the difference and its mean (the offset: zero is the standing pose here, and the model's
there), in degrees, and the range of OpenSim's. The plain angle between the markers of hip, knee and ankle is the
control for the knee.

With CMU's walks: hip and knee of both sides over the cycle of the gait, from the contact of a foot to its next one, the
median over all cycles of a person, and its peak and range next to published norms (M. P. Kadaba et al., 1990,
doi:10.1002/jor.1100080310; J. Perry, "Gait Analysis", 1992: knee flexion reaches about 60°, the hip moves through about
40°).
"""

import warnings
from pathlib import Path

import common
import numpy as np

from skpose import inverse_kinematics
from skpose.biomechanics import gait_events, joint_angles
from skpose.datasets import load_cmu, make_gait
from skpose.io import load_trc
from skpose.keypoints import fit_skeleton, layouts

LAYOUT = layouts["opencap_mocap55"]
MIDDLE = {
    "pelvis_tilt": "pelvis_tilt",
    "pelvis_list": "pelvis_list",
    "pelvis_rotation": "pelvis_rotation",
    "trunk_extension": "lumbar_extension",
    "trunk_bending": "lumbar_bending",
    "trunk_rotation": "lumbar_rotation",
}
OF_SIDES = {
    "hip_flexion": "hip_flexion",
    "hip_adduction": "hip_adduction",
    "hip_rotation": "hip_rotation",
    "knee_flexion": "knee_angle",
    "ankle_dorsiflexion": "ankle_angle",
    "ankle_inversion": "subtalar_angle",
    "shoulder_flexion": "arm_flex",
    "shoulder_adduction": "arm_add",
    "elbow_flexion": "elbow_flex",
}


def read_mot(path, rotations=True):
    """Columns of OpenSim by name; its head states in the line inDegrees whether angles are degrees, returned so."""
    head, _, body = path.read_text().partition("endheader")
    names, *rows = [line.split() for line in body.strip().splitlines()]
    factor = 1.0 if "inDegrees=yes" in head or not rotations else np.degrees(1.0)
    return dict(zip(names, np.array(rows, dtype=float).T * factor, strict=True))


def read_markers(path):
    keypoints = load_trc(path)
    return LAYOUT.keypoints(keypoints, absent="unseen")


def knee_of_markers(keypoints, side):
    """The plain angle between the lines from the knee's marker to the hip's centre and the ankle's marker, degrees."""
    hip, knee, ankle = (
        keypoints.positions[:, keypoints.names.index(f"{side}_{name}")] for name in ("HJC", "knee", "ankle")
    )
    thigh, shank = hip - knee, ankle - knee
    cosine = (thigh * shank).sum(axis=1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shank, axis=1)
    return 180.0 - np.degrees(np.arccos(cosine))


def against_opensim(folder):
    standing = next(folder.glob("static*.trc"))
    still = read_markers(standing)
    skeleton = fit_skeleton(still, LAYOUT)
    zero = inverse_kinematics(still, skeleton).to_motion()
    for path in sorted(folder.glob("*.trc")):
        if path == standing:
            continue
        keypoints = read_markers(path)
        fitted = inverse_kinematics(keypoints, skeleton)
        angles, reference = joint_angles(fitted.to_motion(), zero=zero), read_mot(path.with_name(f"{path.stem}_ik.mot"))
        pairs = [(name, angles[name], reference[theirs]) for name, theirs in MIDDLE.items()]
        for side in ("right", "left"):
            letter = side[0]
            pairs += [(f"{n}_{side}", angles[f"{n}_{side}"], reference[f"{o}_{letter}"]) for n, o in OF_SIDES.items()]
            control = knee_of_markers(keypoints, letter.upper())
            pairs.append((f"  (markers alone: knee, {side})", control, reference[f"knee_angle_{letter}"]))
        print(f"{path.stem}: {fitted}")
        print(f"{'':34}{'r':>7}{'deviation':>11}{'offset':>9}{'range':>8}")
        for name, ours, theirs in pairs:
            seen = np.isfinite(ours)
            off = (ours - theirs)[seen]
            r = np.corrcoef(ours[seen], theirs[seen])[0, 1]
            print(f"{name:34}{r:7.4f}{off.std():10.1f}°{off.mean():8.1f}°{np.ptp(theirs):7.1f}°")


def cycles_of(angles, motion):
    """Hip and knee in 101 phases of each stride of a foot, degrees."""
    events = gait_events(motion)
    for first, _, last in events.strides:
        side, at = events.feet[first], np.linspace(events.frames[first], events.frames[last], 101)
        names = [f"hip_flexion_{side}", f"knee_flexion_{side}"]
        yield [np.interp(at, np.arange(len(motion)), angles[name]) for name in names]


def against_norm(options):
    if options.cmu:
        dataset = load_cmu(options.cmu, rotations="file")
        dataset = dataset[dataset.actions == "walk"]
        motions, subjects = list(dataset.motions), list(dataset.subjects)
    else:
        motion = make_gait(1, 1, activities=["walk"], rotations="file", random_state=0)[0]
        assert np.isfinite(joint_angles(motion)["knee_flexion_left"]).all()
        return
    if options.quick:
        motions, subjects = motions[:3], subjects[:3]
    print(f"{'person':>8}{'cycles':>8}{'peak of the knee':>18}{'range of the knee':>19}{'range of the hip':>18}")
    for subject in dict.fromkeys(subjects):
        cycles = []
        for motion, one in zip(motions, subjects, strict=True):
            if one == subject:
                cycles += cycles_of(joint_angles(motion), motion)
        if not cycles:
            print(f"{subject:>8}{0:8d}")
            continue
        hip, knee = np.median(np.array(cycles), axis=0)
        print(f"{subject:>8}{len(cycles):8d}{knee.max():17.0f}°{np.ptp(knee):18.0f}°{np.ptp(hip):17.0f}°")
    print("norm                            60°                60°               40°")


if __name__ == "__main__":
    parser = common.parser(__doc__, folder=False)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--cmu", metavar="FOLDER")
    options = parser.parse_args()
    common.print_machine()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if options.folder:
            against_opensim(options.folder)
        against_norm(options)
