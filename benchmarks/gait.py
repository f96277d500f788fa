"""Gait events: against force plates, in walks and runs of people, and in recordings that are no gait.

    python benchmarks/gait.py [--cmu FOLDER] [--hdm05 FOLDER] [--plates FOLDER] [--markers FOLDER] [--quick]

The method has one constant of its own: how high above its floor a part of a foot may be while it stands, as a share of
the length of the leg. It is chosen on some of the people, subject 35 of CMU and two of the walks over plates, and what
is reported is measured on the others. The lowest height is taken that shortens the stance of subject 35's walks by no
more than one percentage point, and leaves the contacts on the plates where they are. The first table shows that choice;
the last line is the control, without the condition.

`--plates` has the C3D files Gait.c3d (of BMClab/BMC on GitHub), short.c3d, newwalk.c3d and Walking_Hybrid_2.c3d (of
biomechanics-foundation/c3dio), under these names or with something before them: a person each, markers and two force
plates. `--markers` has static1.trc, walking1.trc and walking1_grf.mot (of keenon/nimblephysics, data/grf/Subject4).
An event of the plates is where the force passes 20 N; the nearest event of its kind is compared, late is positive. Of
C3D files markers of the pelvis stand for the hips.

Then, for each person: strides, cadence, speed, length of steps, share of stance and of double support, means and the
standard deviation over strides. The jogs of HDM05 begin in standing, and their first strides are slow. Last, the
control: recordings of other actions in which strides are found. Without folders the people are generated, on feet that
stand, and say nothing about people.
"""

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import common
import numpy as np
from cycles import stand
from joint_angles import LAYOUT, read_markers, read_mot

from skpose import inverse_kinematics
from skpose.biomechanics import _steps, gait_events, gait_parameters
from skpose.biomechanics._feet import feet_at
from skpose.datasets import load_cmu, load_hdm05, make_gait
from skpose.keypoints import fit_skeleton

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "motions"))
from squats import squats

GAIT = ("walk", "run/jog", "run", "walk on uneven terrain", "jog in a circle")
HEIGHTS = 0.03, 0.04, 0.05, 0.06, 0.07, np.inf
CHOSEN_ON = {"35", "Gait", "short"}
FORCE = 20.0  # N
SHOWN = {"cadence": ".0f", "speed": ".2f", "step_length": ".2f", "stance": ".1f", "double_support": ".1f"}
MARKERS = {  # hips, ankles, fronts of the feet, left and right
    "Gait": "LASI LANK LTOE RASI RANK RTOE",
    "short": "LASI LANK L.TO RASI RANK R.TO",
    "newwalk": "LASI LANK LTOE RASI RANK RTOE",
    "Walking_Hybrid_2": "L_ASIS L_HEEL L_MT_5 R_ASIS R_HEEL R_MT_5",
}


def passes(times, force):
    """Times at which a force comes on and goes off, s; the first or the last is NaN where it is on at the end."""
    on, off = [], []
    for k in np.flatnonzero(np.diff(force > FORCE)):
        at = times[k] + (FORCE - force[k]) / (force[k + 1] - force[k]) * (times[k + 1] - times[k])
        (on if force[k + 1] > FORCE else off).append(at)
    return on, off


def plates_of(folder):
    """Stances that the method finds and events of the plates, by recording: functions, as the height is changed."""
    import ezc3d

    found = {}
    for name, labels in MARKERS.items():
        for path in folder.glob(f"*{name}.c3d"):
            read = ezc3d.c3d(str(path), extract_forceplat_data=True)
            columns = [read["parameters"]["POINT"]["LABELS"]["value"].index(label) for label in labels.split()]
            positions = read["data"]["points"][:3, columns].transpose(1, 2, 0) / 1000.0
            seen = np.flatnonzero((np.abs(np.nan_to_num(positions)).max(axis=2) > 0.0).all(axis=0))
            rate = read["header"]["points"]["frame_rate"]
            feet = feet_at(positions[:, seen], seen, rate)
            events = []
            for plate in read["data"]["platform"]:
                force = np.linalg.norm(plate["force"], axis=0)
                events.append(passes(np.arange(len(force)) / read["header"]["analogs"]["frame_rate"], force))
            found[name] = feet, events
    return found


def stances_on(feet):
    """Times of contacts and of foot offs."""
    stances = _steps.find_stances(feet)
    return [
        np.array([time * feet.step + feet.times[0] for time in times if np.isfinite(time)])
        for times in ([one.contact for one in stances], [one.off for one in stances])
    ]


def markers_of(folder):
    """The events of a recording whose poses are fitted to markers, and those of the plates."""
    standing = read_markers(folder / "static1.trc")
    fitted = inverse_kinematics(read_markers(folder / "walking1.trc"), fit_skeleton(standing, LAYOUT))
    events, forces = gait_events(fitted.to_motion()), read_mot(folder / "walking1_grf.mot", rotations=False)
    found = [events.times[events.kinds == kind] for kind in ("foot contact", "foot off")]
    return found, [passes(forces["time"], forces[f"ground_force_{i}_vy"]) for i in (1, 2)]


def errors(found, events):
    """By how much contacts and foot offs are late, ms."""
    return [
        [1000.0 * (ours[np.abs(ours - time).argmin()] - time) for plate in events for time in plate[kind]]
        for kind, ours in enumerate(found)
    ]


def strides_of(motions):
    """The parameters of all strides of some motions, by name."""
    found = [gait_parameters(events) for events in map(gait_events, motions) if len(events)]
    return {name: np.concatenate([getattr(one, name) for one in found]) if found else np.array([]) for name in SHOWN}


def spread(values, form=".1f"):
    values = np.asarray(values)[np.isfinite(values)]
    std = f" ± {values.std(ddof=1):{form}}" if len(values) > 1 else ""
    return f"{values.mean():{form}}{std}" if len(values) else ""


def choose(groups, plates):
    """Print what the height changes for the people on whom it is chosen."""
    chosen, walks = _steps.LOW, {}
    print(f"\n{'height':>8}{'stance of walks, %':>22}{'of runs':>14}{'contacts, ms late':>22}{'foot offs':>14}")
    for height in HEIGHTS:
        _steps.LOW = height
        shares = [
            strides_of(motions)["stance"]
            for kind in ("walk", "run/jog")
            for (_, person, action), motions in groups.items()
            if person in CHOSEN_ON and action == kind
        ]
        walks[height] = np.mean(shares[0])
        off = [errors(stances_on(feet), events) for name, (feet, events) in plates.items() if name in CHOSEN_ON]
        contacts, offs = (np.concatenate(one) for one in zip(*off, strict=True)) if off else ([], [])
        mark = " *" if height == chosen else ""
        print(
            f"{height:>8}{spread(shares[0]):>22}{spread(shares[1]):>14}{spread(contacts):>22}{spread(offs):>14}{mark}"
        )
    _steps.LOW = chosen
    assert walks[np.inf] - walks[chosen] <= 1.0


def report_plates(plates, markers):
    """Print the errors of each recording over plates, and of all on which nothing was chosen."""
    print(f"\n{'walk over plates':<20}{'contacts, ms late':>26}{'foot offs':>26}")
    rows = {name: errors(stances_on(feet), events) for name, (feet, events) in plates.items()}
    if markers:
        rows["walking1"] = errors(*markers)
    for name, both in rows.items():
        words = ["  ".join(f"{one:.0f}" for one in kind) for kind in both]
        print(f"{name:<20}{words[0]:>26}{words[1]:>26}{'  chosen on' if name in CHOSEN_ON else ''}")
    others = [both for name, both in rows.items() if name not in CHOSEN_ON]
    contacts, offs = (np.concatenate(kind) for kind in zip(*others, strict=True))
    print(f"{'the others':<20}{spread(contacts):>26}{spread(offs):>26}")


def report(groups):
    """Print the gait of each person, and check that runs have flight."""
    print(f"\n{'':<8}{'person':<8}{'action':<24}{'strides':>8}", end="")
    print(f"{'cadence':>12}{'speed, m/s':>14}{'step, m':>14}{'stance, %':>14}{'double, %':>14}")
    for (source, person, action), motions in groups.items():
        if action in GAIT:
            found = strides_of(motions)
            print(f"{source:<8}{person:<8}{action:<24}{len(found['stance']):>8}", end="")
            print(f"{spread(found['cadence'], '.0f'):>12}", end="")
            print("".join(f"{spread(found[name], form):>14}" for name, form in list(SHOWN.items())[1:]), end="")
            print("  chosen on" if person in CHOSEN_ON else "")
            assert "walk" in action or found["stance"].mean() < 50.0, (person, action)


def control(groups):
    """Print in how many recordings of other actions strides are found."""
    print(f"\n{'other actions':<40}{'recordings':>12}{'with strides':>14}")
    others = [action for _, _, action in groups if action not in GAIT]
    for action in dict.fromkeys(others):
        motions = [motion for (_, _, one), some in groups.items() if one == action for motion in some]
        counts = [len(gait_events(motion).strides) for motion in motions]
        print(f"{action:<40}{len(counts):>12}{np.count_nonzero(counts):>14}")


def generated():
    """Walks, runs and squats."""
    groups = {}
    gait = make_gait(2, 1, duration=4, random_state=0)
    for motion, person, action in zip(gait.motions, gait.subjects, gait.actions, strict=True):
        name = {"run": "run/jog"}.get(str(action), str(action))
        groups["made", "35" if person == gait.subjects[0] else str(person), name] = [stand(motion)]
    squat = squats(0, n=3)[0]
    drift = np.linspace([0.0, 0.0, 0.0], [0.1, 0.0, 0.1], len(squat))
    groups["made", "squats", "squat"] = [replace(squat, root_positions=drift)]
    return groups


def main():
    parser = common.parser_of_both(__doc__)
    parser.add_argument("--plates", type=Path, metavar="FOLDER", help="four C3D files with force plates, see above")
    parser.add_argument("--markers", type=Path, metavar="FOLDER", help="markers and forces, see above")
    options = parser.parse_args()
    common.print_machine()
    groups = {}
    for source, load, folder in (("CMU", load_cmu, options.cmu), ("HDM05", load_hdm05, options.hdm05)):
        dataset = load(folder) if folder else []
        for k in range(0, len(dataset), 5 if options.quick else 1):
            key = source, str(dataset.subjects[k]), str(dataset.actions[k])
            stands_still = source == "CMU" and (dataset.subjects[k], dataset.trials[k]) == ("03", "02")
            groups.setdefault(key, []).append(dataset[k][24:] if stands_still else dataset[k])  # then it jumps
    groups = groups or generated()
    plates = plates_of(options.plates) if options.plates else {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if any(person == "35" for _, person, _ in groups):
            choose(groups, plates)
        if plates:
            report_plates(plates, markers_of(options.markers) if options.markers else None)
    report(groups)
    control(groups)


if __name__ == "__main__":
    main()
