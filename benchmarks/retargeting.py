"""Retargeting: how near does a motion of one person's file come to it on the skeleton of another person's file?

    python benchmarks/retargeting.py [--cmu FOLDER OF CMU FILES --hdm05 FOLDER OF HDM05 FILES]
        [--bandai-namco FILE.bvh] [--robots FOLDER OF MJCF FILES] [--quick]

First all pairs of rigs, each with the names, the rest pose, the trunk and the axes of its files: one person and one
motion as files of eight rigs, which `tests/rigs.py` writes, SMPL as `load_amass` reads it without a model, the
humanoid, and recordings of CMU, HDM05 and Bandai-Namco where they are given. By ``method="auto"`` and
``scale="lengths"``: how many joints have counterparts, how many degrees thighs, shanks, upper arms and forearms are
off, and how many centimetres hips, knees, ankles, shoulders, elbows and wrists, from the middle between the hips,
of the motion scaled. These are found by names that are typed here, not by the library's tables. Controls are what
has similar names and is no person: a dog, a hand, robots. They should be refused.

Then the first motion of each set at 6 Hz, on the skeleton of the first motion of the other, by each method, with
``scale="lengths"``. "Hinges" is the skeleton as it is, "balls" has ball joints only. Distances are those of the joints
in the world, the motion scaled; directions are those of the bones. Without folders the two are of generated gait.
"""

import io
import sys
import warnings
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import common
import numpy as np
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, forward_kinematics
from skpose.datasets import MotionDataset, load_cmu, load_hdm05, make_gait
from skpose.io import load_amass, load_bvh
from skpose.kinematics import retarget

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import rigs

SIDES = ("left", "right")
BONES = (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
# Names of the joints at hips, knees, ankles, shoulders, elbows and wrists; {0} is the side, {1} its letter.
LIMBS = {
    "ASF": ("{1}hipjoint", "{1}femur", "{1}tibia", "{1}clavicle", "{1}humerus", "{1}wrist"),
    "SMPL": ("{0}_hip", "{0}_knee", "{0}_ankle", "{0}_shoulder", "{0}_elbow", "{0}_wrist"),
    "humanoid": ("{0}_pelvis", "{0}_thigh", "{0}_shank", "{0}_clavicle", "{0}_upper_arm", "{0}_forearm"),
}
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


def limbs_by(patterns):
    """Return the names of the joints of the limbs by side and joint."""
    pairs = zip(rigs.LIMBS, patterns, strict=True)
    return {f"{side} {joint}": name.format(side, side[0]) for joint, name in pairs for side in SIDES}


def people(options):
    """Return a motion of each rig and the names of the joints of its limbs."""
    segments = rigs.random_segments(8)
    found = {name: (rigs.motion_of(name, segments)[0], rigs.limbs_of(name)) for name in rigs.RIGS}
    rng = np.random.default_rng(0)
    file = io.BytesIO()
    np.savez(file, poses=rng.normal(scale=0.3, size=(8, 72)), trans=np.zeros((8, 3)), mocap_framerate=30.0)
    file.seek(0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of bones with the lengths of a mean person
        found["SMPL"] = load_amass(file, up="z"), limbs_by(LIMBS["SMPL"])
    gait = make_gait(n_subjects=1, n_sequences=1, rotations="file", random_state=0)
    found["humanoid"] = gait.motions[0].resample(4), limbs_by(LIMBS["humanoid"])
    if options.cmu:
        found["CMU"] = load_cmu(options.cmu, rotations="file")[0].resample(4), limbs_by(LIMBS["ASF"])
    if options.hdm05:
        found["HDM05"] = load_hdm05(options.hdm05, rotations="file")[0].resample(4), limbs_by(LIMBS["ASF"])
    if options.bandai_namco:
        file = load_bvh(options.bandai_namco, scale=0.01).resample(4)
        found["Bandai-Namco, file"] = file, rigs.limbs_of("Bandai-Namco")
    return found


def limbs_in_space(motion, names):
    """Return the joints of the limbs in the world by side and joint, from the middle between the hips."""
    positions = dict(zip(motion.skeleton.joint_names, world(motion)[:, :-1].swapaxes(0, 1), strict=True))
    middle = (positions[names["left hip"]] + positions[names["right hip"]]) / 2.0
    return {joint: positions[name] - middle for joint, name in names.items()}


def measure(motion, names, result, new_names):
    """Return how far directions of limbs are off, degrees, and joints, cm, of the motion scaled by their lengths."""
    a, b = limbs_in_space(motion, names), limbs_in_space(result, new_names)
    bones = [np.stack([x[f"{s} {j}"] - x[f"{s} {i}"] for s in SIDES for i, j in BONES], axis=1) for x in (a, b)]
    lengths = [np.linalg.norm(bone, axis=2, keepdims=True) for bone in bones]
    chords = np.linalg.norm(bones[0] / lengths[0] - bones[1] / lengths[1], axis=2)
    factor = lengths[1].sum() / lengths[0].sum()
    apart = np.stack([np.linalg.norm(b[joint] - factor * a[joint], axis=1) for joint in a], axis=1)
    return np.degrees(2.0 * np.arcsin(np.minimum(chords / 2.0, 1.0))), 100.0 * apart


def all_pairs(found):
    """Print what each motion is on the skeleton of each rig."""
    tables = {"joints with counterparts": {}, "directions of limbs, mean / largest, degrees": {}}
    tables["joints of limbs, mean / largest, cm"] = {}
    n_refused = 0
    for here, (motion, names) in found.items():
        for there, (other, new_names) in found.items():
            cells = ["–"] * 3
            if here != there:
                try:
                    dataset = MotionDataset([motion], rotations="file").retarget(other, method="auto", scale="lengths")
                except ValueError as error:
                    cells = ["refused"] * 3
                    n_refused += 1
                    print(f"{here} → {there} refused: {error}")
                else:
                    report = dataset.retargeting[0]
                    counts = [int(word) for word in report.split() if word.isdigit()][:2] or ["all"]
                    cells = ["/".join(map(str, counts)) + " p" * report.startswith("positions")]
                    for off in measure(motion, names, dataset[0], new_names):
                        cells.append(f"{off.mean():.1f} / {off.max():.1f}")
            for table, cell in zip(tables.values(), cells, strict=True):
                table[here, there] = cell
    for title, table in tables.items():
        print(f"\n{title}; p: by positions, as joints are hinges; rows: the motion, columns: the skeleton")
        print("| |", " | ".join(found), "|")
        print("|---" * (len(found) + 1) + "|")
        for here in found:
            print(f"| {here} |", " | ".join(table[here, there] for there in found), "|")
    print(f"\nrefused: {n_refused} of {len(found) * (len(found) - 1)}")


def tree(rows):
    """Return a skeleton of ball joints from rows of a name, a parent and an offset."""
    return Skeleton([Bone(name, parent, offset, "rotvec") for name, parent, offset in rows], "parent")


def dog():
    """Return a dog with the names of a person, as in the recordings of a public set, and a tail."""
    rows = [("Spine", None, (0, 0, 0.2)), ("Spine1", "Spine", (0, 0, 0.3)), ("Neck", "Spine1", (0, 0.05, 0.2))]
    rows += [("Head", "Neck", (0, 0.1, 0.1)), ("Tail", None, (0, 0, -0.1)), ("Tail1", "Tail", (0, 0, -0.1))]
    for side, x in (("Left", 0.08), ("Right", -0.08)):
        arm = [f"{side}{part}" for part in ("Shoulder", "Arm", "ForeArm", "Hand")]
        leg = [f"{side}{part}" for part in ("UpLeg", "Leg", "Foot")]
        rows += zip(arm, ["Spine1", *arm], [(x, 0, 0.05), (0, -0.1, 0), (0, -0.18, -0.02), (0, -0.18, 0)], strict=False)
        rows += zip(leg, [None, *leg], [(x, 0, 0), (0, -0.18, 0.05), (0, -0.18, -0.08)], strict=False)
    return tree(rows)


def robot(path):
    """Return the bodies of a robot in MJCF as a skeleton."""
    rows = []

    def add(body, parent):
        name, offset = body.get("name"), [float(x) for x in body.get("pos", "0 0 0").split()]
        if parent is not None:
            rows.append((name, None if parent == "" else parent, offset))
        for child in body.findall("body"):
            add(child, "" if parent is None else name)

    add(ElementTree.parse(path).find("worldbody").find("body"), None)
    return tree(rows)


def controls(found, folder):
    """Print which skeletons that are no person get the motions of people, and people theirs."""
    others = {"dog": dog()}
    fingers = [
        (f"left_{finger}{i}", f"left_{finger}{i - 1}" * (i > 1) or None)
        for finger in ("thumb", "index")
        for i in (1, 2)
    ]
    others["hand"] = tree([(name, parent, (0.03, 0.0, 0.0)) for name, parent in fingers])
    others |= {path.stem: robot(path) for path in sorted(Path(folder).glob("*.xml"))} if folder else {}
    for name, skeleton in others.items():
        still = Motion(skeleton, np.zeros((2, skeleton.n_dofs)), 30)
        refused = 0
        for motion, _ in found.values():
            for one, target in ((motion, skeleton), (still, motion.skeleton)):
                try:
                    retarget(one, target, method="auto")
                except ValueError:
                    refused += 1
        print(f"control {name}, {skeleton.n_joints} joints: {refused} of {2 * len(found)} refused")


def main():
    arguments = common.parser_of_both(__doc__)
    arguments.add_argument("--bandai-namco", help="a BVH file of Bandai-Namco")
    arguments.add_argument("--robots", help="a folder of robots as MJCF")
    options = arguments.parse_args()
    common.print_machine()
    found = people(options)
    if options.quick:
        found = {name: found[name] for name in ("CMU as BVH", "Bandai-Namco", "Mixamo", "humanoid")}
    all_pairs(found)
    controls(found, options.robots)
    print()
    if options.quick or not (options.cmu and options.hdm05):
        first, second = make_gait(n_subjects=2, n_sequences=1, rotations="file", random_state=0).motions[::2]
        sets = {"person 1": first, "person 2": second}
    else:
        sets = {
            "CMU": load_cmu(options.cmu, rotations="file")[0],
            "HDM05": load_hdm05(options.hdm05, rotations="file")[0],
        }
    (one, first), (two, second) = ((name, motion.resample(6)) for name, motion in sets.items())
    compare(f"{one} → {two}", first, second.skeleton)
    compare(f"{two} → {one}", second, first.skeleton)


if __name__ == "__main__":
    main()
