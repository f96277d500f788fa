"""
A mean that is a pose
=====================

Figure 1 (b) of the paper: the mean of the joint positions of jumping jacks is no pose, its limbs are too short. A mean
that is a pose keeps every bone's length. There are two: the *extrinsic* mean, whose joints are nearest to the mean of
the positions, and the *intrinsic* mean, nearest by geodesics. If SKPOSE_CMU names a folder of CMU files, the example
runs on the motion in it whose joints move farthest.
"""

# sphinx_gallery_tile = (2, 2)

import os

import matplotlib.pyplot as plt
import numpy as np

from skpose import Motion, forward_kinematics
from skpose.datasets import humanoid, load_cmu
from skpose.geodesics import frechet_mean
from skpose.plot import PoseDisplay

# %%
# Arms from the thighs to above the head and back, legs apart and together.
folder = os.environ.get("SKPOSE_CMU")
if folder:
    motions = [motion.resample(1) for motion in load_cmu(folder) if len(motion) > 600]
    spread = [forward_kinematics(m.angles, m.skeleton).std(axis=0).max() for m in motions]
    motion = motions[int(np.argmax(spread))]
else:
    skeleton = humanoid()
    up = 0.5 - 0.5 * np.cos(np.linspace(0, 2 * np.pi, 15))
    angles = np.zeros((len(up), skeleton.n_dofs))
    column = {name: i for i, name in enumerate(skeleton.dof_names)}
    for side, sign in (("left", 1), ("right", -1)):
        angles[:, column[f"{side}_upper_arm_rz"]] = sign * np.radians(165) * up
        angles[:, column[f"{side}_thigh_rz"]] = sign * np.radians(25) * up
    motion = Motion(skeleton, angles, frame_rate=14)
skeleton, X = motion.skeleton, motion.angles
PoseDisplay.from_motion(motion, n_poses=7)
plt.show()

# %%
# Three means. The joints of the first are at their mean positions.
F = forward_kinematics(X, skeleton)
extrinsic, intrinsic = frechet_mean(X, skeleton), frechet_mean(X, skeleton, metric="geodesic", n_jobs=-1)
positions = {
    "mean of the positions": F.mean(axis=0),
    "extrinsic mean": forward_kinematics(extrinsic.pose[None], skeleton)[0],
    "intrinsic mean": forward_kinematics(intrinsic.pose[None], skeleton)[0],
}
figure, axes = plt.subplots(1, 3, figsize=(11, 4.5), sharey=True, layout="constrained")
for ax, (name, joints) in zip(axes, positions.items(), strict=True):
    for pose in F[:: max(1, len(F) // 12)]:
        PoseDisplay.from_positions(pose, skeleton, ax=ax, color="0.85", linewidth=1, markersize=0)
    PoseDisplay.from_positions(joints, skeleton, ax=ax)
    ax.set_title(name)
plt.show()

# %%
# The lengths of their bones.
true = np.linalg.norm(skeleton.offsets, axis=1)
for name, joints in positions.items():
    near = np.concatenate([joints, np.zeros((1, 3))])[skeleton.parents]
    off = np.abs(np.linalg.norm(joints - near, axis=1) - true)[true > 0] / true[true > 0]
    print(f"{name:<22} bones off by up to {off.max():.1e} of their length")
print(f"standard deviation: {extrinsic.variance**0.5:.3f} m by positions, {intrinsic.variance**0.5:.3f} m by geodesics")
