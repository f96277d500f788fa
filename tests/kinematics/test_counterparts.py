"""Counterparts of joints by the names of rigs, against one motion that is written as files of eight rigs.

The truth is that of `rigs`: where the joints of each file are, without the library. Controls are skeletons whose names
look like others and mean something else.
"""

import io
import re

import numpy as np
import pytest
from conftest import in_space
from rigs import LIMBS, RIGS, file_of, limbs_of, motion_of, random_segments

from skpose import Bone, Motion, Skeleton
from skpose.datasets import MotionDataset, humanoid, make_gait
from skpose.io import load_bvh
from skpose.kinematics import find_counterparts, retarget

SEGMENTS = random_segments()
BONES = [("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist")]
SIDES = ("left", "right")
# Names in which a person's arms and legs are in ASF files, in SMPL, and in our own person: typed from those files.
ASF = dict(zip(LIMBS, ("hipjoint", "femur", "tibia", "clavicle", "humerus", "wrist"), strict=True))
SMPL = {joint: joint for joint in LIMBS}
OURS = dict(zip(LIMBS, ("pelvis", "thigh", "shank", "clavicle", "upper_arm", "forearm"), strict=True))


@pytest.fixture(scope="module")
def files():
    return {name: motion_of(name, SEGMENTS) for name in RIGS}


def cmu_person():
    """A skeleton with the names, points and offset frame of CMU's ASF files, in their T-pose."""
    rows = {
        "lhipjoint": (None, (0.09, -0.1, 0.03)),
        "lfemur": ("lhipjoint", (0.15, -0.4, 0)),
        "ltibia": ("lfemur", (0.14, -0.39, 0)),
        "lfoot": ("ltibia", (0.01, -0.03, 0.12)),
        "ltoes": ("lfoot", (0, 0, 0.06)),
        "lowerback": (None, (0, 0.116, -0.01)),
        "upperback": ("lowerback", (0, 0.117, 0)),
        "thorax": ("upperback", (0, 0.117, 0)),
        "lowerneck": ("thorax", (0, 0.089, 0.01)),
        "upperneck": ("lowerneck", (0, 0.088, -0.01)),
        "head": ("upperneck", (0, 0.092, 0)),
        "lclavicle": ("thorax", (0.2, 0.05, -0.01)),
        "lhumerus": ("lclavicle", (0.275, 0, 0)),
        "lradius": ("lhumerus", (0.19, 0, 0)),
        "lwrist": ("lradius", (0.095, 0, 0)),
        "lhand": ("lwrist", (0.037, 0, 0)),
        "lfingers": ("lhand", (0.03, 0, 0)),
        "lthumb": ("lwrist", (0.03, 0, 0.03)),
    }
    bones = []
    for name, (parent, offset) in rows.items():
        middle = ("lowerback", "upperback", "thorax", "lowerneck", "upperneck", "head")
        for side in " " if name in middle else "lr":
            new, above = (one if one in (None, *middle) else side + one[1:] for one in (name, parent))
            mirrored = np.array(offset) * [-1.0 if side == "r" else 1.0, 1, 1]
            bones.append(Bone(new, above, mirrored, "rotvec" if not new.endswith("hipjoint") else ""))
    return Skeleton(bones)


def directions_of_limbs(where, limbs):
    """Directions of thighs, shanks, upper arms and forearms; where is a mapping of names to positions."""
    found = []
    for side in SIDES:
        for start, end in BONES:
            bone = where[limbs[f"{side} {end}"]] - where[limbs[f"{side} {start}"]]
            found.append(bone / np.linalg.norm(bone, axis=1, keepdims=True))
    return np.stack(found, axis=1)


def positions_by_name(motion):
    return dict(zip(motion.skeleton.joint_names, in_space(motion).swapaxes(0, 1), strict=True))


def degrees(a, b):
    return np.degrees(2.0 * np.arcsin(np.linalg.norm(a - b, axis=-1) / 2.0))


# --- what is matched -------------------------------------------------------------------------------------------------


RING = [*zip(RIGS, [*list(RIGS)[1:], next(iter(RIGS))], strict=True), ("Bandai-Namco", "CMU as BVH")]


@pytest.mark.parametrize(("here", "there"), RING)
def test_limbs_keep_their_directions_between_rigs(files, here, there):
    """Joints are where they were but for some centimetres: of one person, whose collarbones begin elsewhere."""
    (motion, where), (other, _) = files[here], files[there]
    dataset = MotionDataset([motion]).retarget(other, method="auto")
    found = positions_by_name(dataset[0])
    a, b = directions_of_limbs(where, limbs_of(here)), directions_of_limbs(found, limbs_of(there))
    if here == there:
        assert dataset.retargeting == ("same numbers",)
    else:
        assert re.match(
            r"orientations, (19|2\d) of [23]\d joints, directions within [\d.]+°(; at rest: .*)?$",
            dataset.retargeting[0],
        )
    # Worlds stay: z is up in the result of a file with z up. Only in the rest pose axes are others.
    assert degrees(a, b).max() < 1e-5
    limbs = [(limbs_of(here)[key], limbs_of(there)[key]) for key in limbs_of(here)]
    apart = np.stack([found[new] - where[old] for old, new in limbs], axis=1)
    assert np.linalg.norm(apart, axis=2).max() < (0.06 if "CMU as BVH" in (here, there) else 0.025)


@pytest.mark.parametrize("name", RIGS)
def test_joints_of_limbs_are_their_counterparts(files, name):
    """Against names that are typed here, and not taken from the library's tables."""
    source = files[name][0].skeleton
    for target, base, pattern in (
        (cmu_person(), ASF, "{0[0]}{1}"),
        (humanoid(), OURS, "{0}_{1}"),
    ):
        found = find_counterparts(source, target)
        places = [(side, joint) for side in SIDES for joint in LIMBS]
        expected = {pattern.format(side, base[joint]): limbs_of(name)[f"{side} {joint}"] for side, joint in places}
        assert {joint: found.get(joint) for joint in expected} == expected
        back = find_counterparts(target, source)
        assert {back[old] for old in expected.values()} == set(expected)


def test_heads_are_not_matched_by_name():
    """The joint "Head" of a BVH file is where the head begins, the "head" of an ASF file its top."""
    bvh = motion_of("LAFAN1", SEGMENTS)[0].skeleton
    found = find_counterparts(bvh, cmu_person())
    assert (found["upperneck"], found["head"]) == ("Head", "Head_end")
    # "LeftShoulder" is where the collarbone begins in the one, and the shoulder in the other.
    found = find_counterparts(bvh, motion_of("Xsens as BVH", SEGMENTS)[0].skeleton)
    assert (found["LeftCollar"], found["LeftShoulder"]) == ("LeftShoulder", "LeftArm")


@pytest.mark.parametrize(
    ("rig", "rename"),
    [
        ("Biped", lambda name: name.replace("Bip01 ", "ValveBiped.")),
        ("Bandai-Namco", lambda name: re.sub(r"^(\w+?)_([LR])", r"\2_\1", name)),
        ("Unreal", lambda name: f"SK_{name}_2"),
    ],
)
def test_prefixes_sides_and_cases(files, rig, rename):
    """A file with other spelling has the same counterparts."""
    other = files["Rokoko"][0].skeleton
    text, _ = file_of(RIGS[rig], SEGMENTS, rename=rename)
    spelt = load_bvh(io.StringIO(text), scale=0.01, up=RIGS[rig].up)
    expected = find_counterparts(files[rig][0].skeleton, other)

    def renamed(name):  # the reader names End Sites by the joint and "_end"
        joint = name.removesuffix("_end")
        return rename(name) if joint == name else f"{rename(joint)}_end"

    assert find_counterparts(spelt.skeleton, other) == {new: renamed(old) for new, old in expected.items()}


def test_hips_stay_where_they_are():
    """The root of one file is at the hips, that of the other 10 cm above them."""
    motion, where = motion_of("Xsens as BVH", SEGMENTS)
    other = motion_of("CMU as BVH", SEGMENTS)[0]
    found = positions_by_name(retarget(motion, other.skeleton, method="orientations"))
    for side in ("Left", "Right"):
        np.testing.assert_allclose(found[f"{side}UpLeg"], where[f"{side}Hip"], atol=1e-9)
        np.testing.assert_allclose(found[f"{side}Foot"], where[f"{side}Ankle"], atol=1e-9)


def test_a_person_whose_joints_are_hinges(files):
    """Positions of the limbs, and of the feet and the head, are reached; those of the trunk have no part in it."""
    dataset = MotionDataset([files["Mixamo"][0]]).retarget(humanoid(), method="auto", scale="lengths")
    found = re.match(r"positions, 15 of 22 joints within ([\d.]+) cm; at rest: (.*)$", dataset.retargeting[0])
    assert float(found[1]) < 12.0
    assert set(found[2].split(", ")) == {"head", *(f"{side}_{end}" for side in SIDES for end in ("hand", "toes"))}


# --- what is refused: controls ---------------------------------------------------------------------------------------


def quadruped(tail=True):
    """A dog with the names of a person, as a public set of recordings has them."""
    rows = [("Spine", None, (0, 0, 0.2)), ("Spine1", "Spine", (0, 0, 0.3)), ("Neck", "Spine1", (0, 0.05, 0.2))]
    rows += [("Head", "Neck", (0, 0.1, 0.1))]
    for side, x in (("Left", 0.08), ("Right", -0.08)):
        rows += [(f"{side}Shoulder", "Spine1", (x, 0, 0.05)), (f"{side}Arm", f"{side}Shoulder", (0, -0.1, 0))]
        rows += [(f"{side}ForeArm", f"{side}Arm", (0, -0.18, -0.02)), (f"{side}Hand", f"{side}ForeArm", (0, -0.18, 0))]
        rows += [(f"{side}UpLeg", None, (x, 0, 0)), (f"{side}Leg", f"{side}UpLeg", (0, -0.18, 0.05))]
        rows += [(f"{side}Foot", f"{side}Leg", (0, -0.18, -0.08))]
    rows += [("Tail", None, (0, 0, -0.1)), ("Tail1", "Tail", (0, 0, -0.1))] * tail
    return Skeleton([Bone(name, parent, offset, "ZXY") for name, parent, offset in rows], "parent")


def still(skeleton, n=2):
    return Motion(skeleton, np.zeros((n, skeleton.n_dofs)), 30)


def test_animals_are_not_people(files):
    person, other = files["LAFAN1"][0], quadruped()
    with pytest.raises(ValueError, match="Tail"):
        retarget(still(other), person.skeleton, method="auto")
    np.testing.assert_allclose(retarget(still(other), other, method="orientations").angles, 0.0, atol=1e-12)


def test_limbs_without_counterparts_are_refused(files):
    """Spine, Neck and Head have equal names, the limbs have no sides."""
    text, _ = file_of(RIGS["Bandai-Namco"], SEGMENTS, rename=lambda name: name.replace("_L", "_a").replace("_R", "_b"))
    motion = load_bvh(io.StringIO(text), scale=0.01)
    with pytest.raises(ValueError, match=r"at rest: 'LeftUpLeg', 'LeftLeg'"):
        retarget(motion, files["CMU as BVH"][0].skeleton, method="auto")


def test_given_joints_complete_those_that_are_found(files):
    """Six joints of the legs are given, and the arms and the spine move too; None leaves a joint at rest."""
    (motion, where), other = files["LAFAN1"], files["Rokoko"][0].skeleton
    legs = {
        f"{side}{new}": f"{side}{old}"
        for side in ("Left", "Right")
        for new, old in (("Thigh", "UpLeg"), ("Shin", "Leg"))
    }
    found = retarget(motion, other, method="orientations", joints=legs)
    a, b = (
        directions_of_limbs(where, limbs_of("LAFAN1")),
        directions_of_limbs(positions_by_name(found), limbs_of("Rokoko")),
    )
    assert degrees(a, b).max() < 1e-5
    still = retarget(motion, other, method="orientations", joints={"Head": None, "Head_end": None})
    np.testing.assert_array_equal(still.angles[:, [name.startswith("Head") for name in other.dof_names]], 0.0)


def test_roots_on_the_ground_are_refused(files):
    """As in files for games: the root is between the feet."""
    bones = [Bone("hips", None, (0, 0.9, 0), "ZXY"), *files["LAFAN1"][0].skeleton.bones]
    bones = [bones[0], *(b._replace(parent=b.parent or "hips") for b in bones[1:])]
    ground = Skeleton(bones, "parent")
    for motion, target in ((files["Mixamo"][0], ground), (still(ground), files["Mixamo"][0].skeleton)):
        with pytest.raises(ValueError, match="root='hips'"):
            retarget(motion, target, method="orientations")


def test_names_of_a_person_with_other_proportions(files):
    """The counterparts are found, with a warning, to check and to pass; they are refused otherwise."""
    text, where = file_of(RIGS["LAFAN1"], SEGMENTS, stretch={"LeftForeArm": 4.3, "RightForeArm": 4.3})
    odd, other = load_bvh(io.StringIO(text), scale=0.01), files["Rokoko"][0].skeleton
    with pytest.raises(ValueError, match="joints="):
        retarget(odd, other, method="orientations")
    with pytest.warns(UserWarning, match="upper arm"):
        joints = find_counterparts(odd.skeleton, other)
    assert joints == find_counterparts(files["LAFAN1"][0].skeleton, other)
    found = positions_by_name(retarget(odd, other, method="orientations", joints=joints))
    a, b = directions_of_limbs(where, limbs_of("LAFAN1")), directions_of_limbs(found, limbs_of("Rokoko"))
    assert degrees(a, b).max() < 1e-5


def test_feet_without_toes_stay_at_rest_with_a_warning(capsys):
    rig = RIGS["LAFAN1"]._replace(leg=[*RIGS["LAFAN1"].leg[:3], ("LeftFoot_end", "floor", "")])
    down = load_bvh(io.StringIO(file_of(rig, SEGMENTS)[0]), scale=0.01).skeleton
    motion = make_gait(1, 1, random_state=0).motions[0][:5]
    with pytest.warns(UserWarning, match="'LeftFoot', 'RightFoot' stay at rest"):
        result = retarget(motion, down, method="orientations", verbose=1)
    assert capsys.readouterr().out.endswith("; at rest: LeftFoot, RightFoot\n")
    np.testing.assert_array_equal(result.angles[:, [i for i, n in enumerate(down.dof_names) if "Foot" in n]], 0.0)


def person_with_trunk(lengths):
    """Legs, arms and a head on a trunk of bones of these lengths."""
    bones, chest = [], None
    for i, length in enumerate(lengths):
        bones.append(Bone(f"bone{i}", chest, (0, length, 0), "rotvec"))
        chest = f"bone{i}"
    for side, x in (("left", 1), ("right", -1)):
        rows = [("hip", None, (0.1 * x, 0, 0)), ("knee", "hip", (0, -0.45, 0)), ("ankle", "knee", (0, -0.42, 0))]
        rows += [("collar", None, (0.05 * x, 0.02, 0)), ("shoulder", "collar", (0.12 * x, 0, 0))]
        rows += [("elbow", "shoulder", (0.28 * x, 0, 0)), ("wrist", "elbow", (0.25 * x, 0, 0))]
        for name, above, offset in rows:
            parent = f"{side}_{above}" if above else (chest if name == "collar" else None)
            bones.append(Bone(f"{side}_{name}", parent, offset, "rotvec"))
    return Skeleton([*bones, Bone("neck", chest, (0, 0.12, 0), "rotvec"), Bone("head", "neck", (0, 0.1, 0), "rotvec")])


def test_joints_of_trunks_are_matched_in_their_order():
    """Bones without a length put several joints of a trunk at one place."""
    rng = np.random.default_rng(0)
    for n in rng.integers(2, 6, (100, 2)):
        lengths = [0.5 * rng.dirichlet(np.ones(k)) * (rng.random(k) > 0.25) + 0.05 * np.eye(k)[0] for k in n]
        found = find_counterparts(*(person_with_trunk(one) for one in lengths))
        pairs = sorted((int(a[4:]), int(b[4:])) for a, b in found.items() if a.startswith("bone") and b is not None)
        assert [b for _, b in pairs] == sorted(b for _, b in pairs)
        assert pairs
