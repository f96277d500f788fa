"""
Robots: shortest paths and a walk
=================================

A robot is a skeleton whose joints are hinges about any axis. (a) How far do its links travel from one configuration to
another, along the straight line in joint space and along the shortest path within joint limits? (b) A walk of a person,
retargeted to a small biped. Both robots are written here; `load_robot` reads them from URDF and MJCF files.
"""

import matplotlib.pyplot as plt
import numpy as np

from skpose import Bone, Motion, Skeleton, forward_kinematics, geodesic, pose_distances
from skpose.datasets import make_gait
from skpose.metrics import Spatial
from skpose.plot import PoseDisplay
from skpose.robots import retarget_to_robot

# %%
# An arm of seven hinges. z points up; an offset is that of a link's far end, in the axes of the link, m.
Z, Y = (0, 0, 1), (0, 1, 0)
hinges = {
    "base": (Z, (0, 0, 0.3), 2.9),
    "shoulder": (Y, (0, 0, 0.2), 2.0),
    "upper_arm": (Z, (0, 0, 0.2), 2.9),
    "elbow": (Y, (0, 0, 0.2), 2.4),
    "forearm": (Z, (0, 0, 0.2), 2.9),
    "wrist": (Y, (0, 0, 0.1), 2.1),
    "hand": (Z, (0.05, 0, 0.1), 2.9),
}
bones, above = [], None
for name, (axis, offset, limit) in hinges.items():
    bones.append(Bone(name, above, offset, "hinge", limits=[(-limit, limit)], axis=axis, dof_name=f"{name}_joint"))
    above = name
arm = Skeleton(bones)
print(arm, arm.dof_names)

# %%
# The arm reaches to one side of its base, and to the other. Its base cannot pass π, so that nothing may be wrapped:
# ``wrap=False``, and ``joint_limits="enforce"``. The distances are how far all links travel. They take no account of
# collisions.
start = np.array([-1.8, 1.4, 0.0, 0.6, 0.0, 0.6, 0.0])
end = np.array([1.8, 1.4, 0.0, 0.6, 0.0, 0.6, 0.0])
line_length = pose_distances([start], [end], skeleton=arm, metric=Spatial(100, wrap=False))[0, 0]
path = geodesic(start, end, arm, joint_limits="enforce")
print(f"straight line {line_length:.2f} m, shortest path {path.curve_length:.2f} m")

n = 60
configurations = {
    f"straight line, {line_length:.2f} m": np.linspace(start, end, n),
    f"shortest path, {path.curve_length:.2f} m": path.resample(n),
}
figure = plt.figure(figsize=(10, 4.6), layout="constrained")
for i, (title, poses) in enumerate(configurations.items(), start=1):
    links = np.concatenate([np.zeros((n, 1, 3)), forward_kinematics(poses, arm)], axis=1)
    ax = figure.add_subplot(1, 2, i, projection="3d")
    for frame in np.linspace(0, n - 1, 9).astype(int):
        shade = plt.get_cmap("viridis")(0.9 * frame / (n - 1))
        ax.plot(*links[frame].T, color=shade, linewidth=2, marker="o", markersize=3)
    ax.plot(*links[:, -1].T, color="#d55e00", linewidth=2.5)
    ax.set(
        title=title, xlabel="x (m)", ylabel="y (m)", zlabel="z (m)", xlim=(-0.8, 0.8), ylim=(-0.8, 0.8), zlim=(0, 0.8)
    )
    ax.set_box_aspect((2, 2, 1), zoom=0.85)
    ax.locator_params(nbins=5)
    ax.view_init(elev=35, azim=-25)
plt.show()

# %%
# The share of its limits that each joint uses: enforced limits are not exceeded. The elbow folds, and the hand passes
# close to the base.
lower, upper = arm.limits.T
share = np.abs(path.resample(200) / upper).max(axis=0)
for name, value in zip(arm.dof_names, share, strict=True):
    print(f"{name:<16} uses {value:4.0%} of its limit")

# %%
# A biped of 12 hinges with a fixed mast. x points forward and z up.
hinges = {
    "hip_roll": ((1, 0, 0), (-0.5, 0.5), (0, 0, 0)),
    "hip_yaw": (Z, (-0.8, 0.8), (0, 0, 0)),
    "hip": (Y, (-2.0, 1.0), (0, 0, 0)),
    "knee": (Y, (0.0, 2.3), (0, 0, -0.3)),
    "ankle": (Y, (-0.9, 0.6), (0, 0, -0.3)),
    "foot": ((1, 0, 0), (-0.3, 0.3), (0, 0, 0)),
}
bones = [Bone("mast", None, (0, 0, 0.35))]
for side, y in (("left", 0.1), ("right", -0.1)):
    above, offset = None, (0, y, 0)
    for name, (axis, limits, after) in hinges.items():
        joint = f"{side}_{name}"
        offset = after if above else offset
        bones.append(Bone(joint, above, offset, "hinge", limits=[limits], axis=axis, dof_name=f"{joint}_joint"))
        above = joint
    bones.append(Bone(f"{side}_toe", above, (0.12, 0, -0.05)))
biped = Skeleton(bones, offset_frame="parent")

# %%
# The links and their counterparts in the person, whose legs are longer. Feet on the ground are held still;
# this walk is in place, as on a treadmill, so that no foot stands.
walk = make_gait(n_subjects=1, n_sequences=1, activities=["walk"], random_state=0).motions[0]
counterparts = {"hip_roll": "pelvis", "knee": "thigh", "ankle": "shank", "toe": "foot"}
joints = {f"{side}_{ours}": f"{side}_{theirs}" for side in ("left", "right") for ours, theirs in counterparts.items()}
retargeted = retarget_to_robot(walk, biped, joints=joints, verbose=1)

figure, axes = plt.subplots(2, 1, figsize=(10, 6), layout="constrained")
stride = slice(0, 70)
PoseDisplay.from_motion(walk[stride], n_poses=9, projection="zy", ax=axes[0])
PoseDisplay.from_motion(retargeted[stride], n_poses=9, projection="xz", ax=axes[1])
axes[0].set_title("a person")
axes[1].set_title("the biped")
plt.show()

# %%
# The player shows both, and the path of the arm.
trajectory = Motion(arm, path.resample(61), 30, up="z")
trajectory.play()
