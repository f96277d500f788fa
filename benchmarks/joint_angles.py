"""Joint angles and gait events: against OpenSim, against the norm of walking, and against force plates.

    python benchmarks/joint_angles.py [FOLDER OF MARKERS AND ANGLES] [--cmu FOLDER OF CMU FILES] [--plates C3D ...]

The folder has recordings of one person: a standing one whose name begins with "static", and others, each as markers
(NAME.trc) and with OpenSim's angles (NAME_ik.mot). One skeleton is fitted to the standing recording, poses to the
markers of each other one; zero is the standing recording. Printed is, for each angle, the correlation with OpenSim's,
the standard deviation of the difference and its mean (the offset: zero is the standing pose here, and the model's
there), in degrees, and the range of OpenSim's. The plain angle between the markers of hip, knee and ankle is the
control for the knee. Then hip and knee once more with hips from the markers of the pelvis: means, and regressions.

With CMU's walks: hip and knee of both sides over the cycle of the gait, from the contact of a foot to its next one, the
median over all cycles of a person, and its peak and range next to published norms (M. P. Kadaba et al., 1990,
doi:10.1002/jor.1100080310; J. Perry, "Gait Analysis", 1992: knee flexion reaches about 60°, the hip moves through about
40°).

With C3D files of force plates: foot contacts and offs minus those of the plates, ms. Controls are the foot farthest
ahead of the pelvis and behind it (J. A. Zeni et al., 2008, doi:10.1016/j.gaitpost.2007.07.007), and the vertical speed
of the foot (C. M. O'Connor et al., 2007, doi:10.1016/j.gaitpost.2006.05.016).
"""

import warnings
from dataclasses import replace
from pathlib import Path

import common
import numpy as np
from scipy.signal import butter, find_peaks, sosfiltfilt

from skpose import inverse_kinematics
from skpose.biomechanics import joint_angles
from skpose.biomechanics._gait_events import feet_at, find_stances
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


def with_hips(rule):
    """The layout with hips by a rule, from the markers of the pelvis alone."""
    parents = {name: parent for name, parent in LAYOUT.parents.items() if not name.endswith("_reg")}
    hips = {}
    for side, other in ("LR", "RL"):
        pelvis = f"{side}.ASIS", f"{other}.ASIS", f"{side}.PSIS", f"{other}.PSIS"
        leg = (f"{side}_knee", f"{side}_ankle") if rule == "davis" else ()
        hips[f"{side}_HJC"] = pelvis[::2] if rule == "mean" else (rule, *pelvis, *leg)
    return replace(
        LAYOUT,
        names=[name for name in LAYOUT.names if "HJC" not in name],
        parents=parents,
        rigid=LAYOUT.rigid & parents.keys(),
        midpoints=LAYOUT.midpoints | hips,
    )


def read_markers(path, layout):
    keypoints = load_trc(path)
    names = [name for name in keypoints.names if "HJC" not in name or layout is LAYOUT]
    return layout.keypoints(keypoints.select(names), absent="unseen")


def knee_of_markers(keypoints, side):
    """The plain angle between the lines from the knee's marker to the hip's centre and the ankle's marker, degrees."""
    hip, knee, ankle = (
        keypoints.positions[:, keypoints.names.index(f"{side}_{name}")] for name in ("HJC", "knee", "ankle")
    )
    thigh, shank = hip - knee, ankle - knee
    cosine = (thigh * shank).sum(axis=1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shank, axis=1)
    return 180.0 - np.degrees(np.arccos(cosine))


def against_opensim(folder, layout, only=""):
    standing = next(folder.glob("static*.trc"))
    still = read_markers(standing, layout)
    skeleton = fit_skeleton(still, layout)
    zero = inverse_kinematics(still, skeleton).to_motion()
    for path in sorted(folder.glob("*.trc")):
        if path == standing:
            continue
        keypoints = read_markers(path, layout)
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
        shown = ("hip_flexion", "knee", "  (") if only else ""
        for name, ours, theirs in (pair for pair in pairs if pair[0].startswith(shown)):
            seen = np.isfinite(ours)
            off = (ours - theirs)[seen]
            r = np.corrcoef(ours[seen], theirs[seen])[0, 1]
            print(f"{name:34}{r:7.4f}{off.std():10.1f}°{off.mean():8.1f}°{np.ptp(theirs):7.1f}°")


def against_norm(options):
    if options.cmu:
        dataset = load_cmu(options.cmu, rotations="file")
        dataset = dataset[dataset.actions == "walk"]
    else:
        motion = make_gait(1, 1, activities=["walk"], rotations="file", random_state=0)[0]
        assert np.isfinite(joint_angles(motion)["knee_flexion_left"]).all()
        return
    table = joint_angles(dataset[:3] if options.quick else dataset)
    print(f"{'person':>8}{'cycles':>8}{'peak of the knee':>18}{'range of the knee':>19}{'range of the hip':>18}")
    for subject, rows in table.groupby("subject"):
        hip, knee = (
            rows[rows["angle"] == name].groupby("phase [%]")["value [deg]"].median()
            for name in ("hip_flexion", "knee_flexion")
        )
        print(
            f"{subject:>8}{(rows['angle'] == 'hip_flexion').sum() // 101:8d}"
            f"{knee.max():17.0f}°{np.ptp(knee):18.0f}°{np.ptp(hip):17.0f}°"
        )
    print("norm                            60°                60°               40°")


# Markers near hips, ankles, toes and heels, without the letter of the side, in several sets.
MARKERS = ("ASI", "_ASIS"), ("ANK", "_SHANK_4"), ("TOE", ".TO", "_MT_5"), ("HEE", "_HEEL")


def against_plates(path):
    """The foot contacts and offs of a C3D file with z up by three rules, minus those of its force plates, ms."""
    import ezc3d

    file = ezc3d.c3d(str(path))
    point, plates = file["parameters"]["POINT"], file["parameters"]["FORCE_PLATFORM"]
    labels, rate = point["LABELS"]["value"], point["RATE"]["value"][0]
    sides = [[next(s + m for m in marks if s + m in labels) for marks in MARKERS] for s in "LR"]
    chosen = [labels.index(name) for side in sides for name in side]
    positions = file["data"]["points"][:3, chosen].transpose(1, 2, 0) / 1000.0
    seen = np.isfinite(positions).all(axis=(0, 2)) & (positions != 0.0).any(axis=2).all(axis=0)
    rows = np.flatnonzero(seen)
    every = np.arange(rows[0], rows[-1] + 1)
    positions = np.array([[np.interp(every, rows, x[rows]) for x in mark.T] for mark in positions]).swapaxes(1, 2)
    feet = feet_at(positions[[0, 1, 2, 4, 5, 6]], np.ones((2, len(every)), dtype=bool), rate)
    stances, ahead = find_stances(feet), feet.travel / np.linalg.norm(feet.travel, axis=1, keepdims=True)
    heels = sosfiltfilt(butter(2, 10.0, fs=rate, output="sos"), positions[[3, 7]], axis=1)
    analog, analog_rate = file["data"]["analogs"][0], file["parameters"]["ANALOG"]["RATE"]["value"][0]
    for channels, kind in zip(np.transpose(plates["CHANNEL"]["value"]), plates["TYPE"]["value"], strict=True):
        force = analog[channels[4:8] - 1].sum(axis=0) if kind == 3 else analog[channels[2] - 1]
        force = np.abs(force - np.median(force[: len(force) // 50]))
        force = sosfiltfilt(butter(2, min(50.0, analog_rate / 2.5), fs=analog_rate, output="sos"), force)
        off = np.flatnonzero(force <= 0.03 * np.quantile(force, 0.99))
        end = np.searchsorted(off, force.argmax())
        true = (off[end - 1] + 1) / analog_rate, (off[end] - 1) / analog_rate
        one = min(stances, key=lambda one: abs(np.nan_to_num((rows[0] + one.contact) / rate, nan=np.inf) - true[0]))
        heel, toe = heels[one.side] - feet.pelvis, feet.toes[one.side] - feet.pelvis
        fore, aft = (heel[:, :2] * ahead).sum(axis=1), (toe[:, :2] * ahead).sum(axis=1)
        rise = np.gradient((heels[one.side] + feet.toes[one.side])[:, 2] / 2.0, feet.step)
        rules = {
            "skpose": ([one.contact], [one.off]),
            "Zeni": [find_peaks(x, prominence=0.1 * feet.leg)[0] for x in (fore, -aft)],
            "O'Connor": [find_peaks(x, prominence=0.2)[0] for x in (-rise, rise)],
        }
        words = []
        for name, events in rules.items():
            errors = [
                1e3 * ((rows[0] + np.asarray(rows_of)) / rate - t) for rows_of, t in zip(events, true, strict=True)
            ]
            words.append(f"{name} " + ", ".join(f"{each[np.abs(each).argmin()]:+.0f}" for each in errors))
        print(f"{path.stem:32}{'LR'[one.side]}: contact, off: {'; '.join(words)} ms")


if __name__ == "__main__":
    parser = common.parser(__doc__, folder=False)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--cmu", metavar="FOLDER")
    parser.add_argument("--plates", nargs="+", type=Path, metavar="C3D")
    options = parser.parse_args()
    common.print_machine()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if options.folder:
            against_opensim(options.folder, LAYOUT)
            for rule in ("mean", "harrington", "davis"):
                print(f"--- hips: {rule}")
                against_opensim(options.folder, with_hips(rule), only=rule)
        for path in options.plates or ():
            against_plates(path)
        against_norm(options)
