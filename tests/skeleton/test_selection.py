"""Selection of joints."""

import numpy as np
import pytest

from skpose import forward_kinematics
from skpose.datasets import humanoid, make_gait


def test_joints_keep_what_carries_them():
    skeleton = humanoid()
    part = skeleton.select(["left_hand", "neck"])
    assert part.joint_names == (
        "abdomen",
        "chest",
        "neck",
        "left_clavicle",
        "left_upper_arm",
        "left_forearm",
        "left_hand",
    )
    assert part.select() == part
    assert skeleton.select() == skeleton
    assert skeleton.select(["left_hand", "neck"], drop="left_forearm").joint_names == ("abdomen", "chest", "neck")


def test_positions_of_what_is_kept_stay():
    motion = make_gait(1, 1, duration=0.2, random_state=0).motions[0]
    for arguments in (
        {"joints": "right_toes"},
        {"drop": ["chest"]},
        {"joints": ["head", "left_foot"], "drop": "left_toes"},
    ):
        part = motion.select(**arguments)
        kept = [motion.skeleton.joint_names.index(name) for name in part.skeleton.joint_names]
        np.testing.assert_array_equal(part.angles, motion.angles[:, part.skeleton.columns_in(motion.skeleton)])
        np.testing.assert_allclose(
            forward_kinematics(part.angles, part.skeleton),
            forward_kinematics(motion.angles, motion.skeleton)[:, kept],
            atol=1e-14,
        )
        np.testing.assert_array_equal(part.root_positions, motion.root_positions)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"joints": "left_hnd"}, "did you mean 'left_hand'"),
        ({"drop": ["hip"]}, "drop has 'hip'"),
        ({"joints": "left_pelvis"}, "bone with dofs"),
    ],
)
def test_invalid_selections_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        humanoid().select(**arguments)
