"""BVH files of fitted keypoints: joints stand where the points of their names were seen."""

import numpy as np
import pytest
from conftest import in_space
from people import ALONE, moving, standing_in
from scipy.spatial.transform import Rotation

from skpose import inverse_kinematics
from skpose.biomechanics import joint_angles
from skpose.io import load_bvh, save_bvh
from skpose.keypoints import fit_skeleton, layouts


def fitted(layout, positions):
    keypoints = layout.keypoints(positions, 25)
    return inverse_kinematics(keypoints, fit_skeleton(keypoints, layout)).to_motion()


@pytest.mark.parametrize("name", ["coco17", "smpl24", "opencap43"])
def test_joints_are_at_the_points_of_their_names(name, tmp_path):
    layout = layouts[name].without(ALONE.get(name, []))
    motion = fitted(layout, moving(layout, n=5))
    save_bvh(tmp_path / "a.bvh", motion)
    back = load_bvh(tmp_path / "a.bvh")
    found = dict(zip(back.skeleton.joint_names, np.moveaxis(in_space(back), 1, 0), strict=True))
    found[back.root_name] = back.root_positions
    for point, positions in zip(motion.skeleton.joint_names, np.moveaxis(in_space(motion), 1, 0), strict=True):
        np.testing.assert_allclose(found[point], positions, rtol=0, atol=1e-6)
    pybvh = pytest.importorskip("pybvh")
    other = pybvh.read_bvh_file(tmp_path / "a.bvh", world_up="+y")
    for node, positions in zip(other.nodes, np.moveaxis(other.node_positions(centered="world"), 1, 0), strict=True):
        np.testing.assert_allclose(found.get(node.name, positions), positions, rtol=0, atol=1e-6)


def test_the_library_reads_its_own_file(tmp_path):
    """A knee that bends by up to 60° bends as much in the file."""
    layout, bent = layouts["coco17"], np.linspace(0, 60, 10)
    at = standing_in(layout)
    positions = np.array([[at[name] for name in layout.names]] * 10)
    knee, ankle = at["left_knee"], at["left_ankle"]
    turned = Rotation.from_euler("x", bent[:, None], degrees=True).apply(ankle - knee)
    positions[:, layout.names.index("left_ankle")] = knee + turned
    save_bvh(tmp_path / "a.bvh", fitted(layout, positions))
    angles = joint_angles(load_bvh(tmp_path / "a.bvh"))
    flexion = angles.degrees[:, list(angles.names).index("knee_flexion_left")]
    thigh, shank = knee - at["left_hip"], turned
    cosine = shank @ thigh / np.linalg.norm(thigh) / np.linalg.norm(shank, axis=1)
    np.testing.assert_allclose(flexion, np.degrees(np.arccos(cosine)), atol=1.0)
