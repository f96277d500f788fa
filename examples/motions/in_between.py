"""
In-betweens of a stride
=======================

A few key poses of a walk are all that is kept, and `skpose.geodesics.interpolate` fills in the frames between: along
geodesics, or on a smooth spline of poses, and the movement of the root where the keys have one. Joint by joint, slerp
and the cubic spline of the angles do so too. How near does each come to the frames that were left out?
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import CubicSpline

from skpose import Motion, forward_kinematics
from skpose.datasets import make_gait
from skpose.geodesics import interpolate
from skpose.view import player

walk = make_gait(1, 1, activities=["walk"], duration=4, frame_rate=60, rotations="file", random_state=0)[0]
skeleton, rate, every = walk.skeleton, walk.frame_rate, 12
walk = walk[60 : 60 + 8 * every + 1]
keys = walk[::every]  # a motion with fewer frames, and their times
print(f"{len(keys)} key poses for {len(walk)} frames, {every / rate:.1f} s from key to key")

# %%
# Each method gives a pose for each frame.
filled = {
    "slerp": keys.to_rotvec().resample(rate),
    "geodesic": interpolate(keys, frame_rate=rate, method="geodesic"),
    "cubic Euler": Motion(skeleton, CubicSpline(keys.times, keys.angles, bc_type="natural")(walk.times), rate),
    "spline": interpolate(keys, frame_rate=rate),
}
truth = forward_kinematics(walk.angles, skeleton)
left_out = np.arange(len(walk)) % every > 0
places = {name: forward_kinematics(motion.angles, motion.skeleton) for name, motion in filled.items()}
for name, found in places.items():
    squares = np.square(found - truth)[left_out].sum(axis=2)
    print(f"{name:<12}{100 * np.sqrt(squares.mean()):6.2f} cm off")

# %%
# The path of the left foot as seen from the side, and how far all joints are off at each time.
foot = skeleton.joint_names.index("left_foot")
colours = {"slerp": "#999999", "geodesic": "#e69f00", "cubic Euler": "#56b4e9", "spline": "#d55e00"}
figure, (left, right) = plt.subplots(2, 1, figsize=(9, 8), layout="constrained")
left.plot(truth[:, foot, 2], truth[:, foot, 1], color="black", linewidth=3, label="left out")
left.plot(truth[::every, foot, 2], truth[::every, foot, 1], "o", color="black", label="keys")
for name, found in places.items():
    left.plot(found[:, foot, 2], found[:, foot, 1], color=colours[name], label=name)
    error = 100 * np.sqrt(np.square(found - truth).sum(axis=2).mean(axis=1))
    right.plot(np.arange(len(walk)) / rate, error, color=colours[name], label=name)
left.set(xlabel="forwards (m)", ylabel="up (m)", title="path of the left foot, seen from the hips")
left.legend(ncols=3)
right.set(xlabel="time (s)", ylabel="root of the mean square over joints (cm)", title="error of the joint positions")
right.legend()
plt.show()

# %%
# The frames that were left out, and two of the methods, in one picture: with slerp the speed jumps at each key.
shown = {"left out": Motion(skeleton, walk.angles, rate), "slerp": filled["slerp"], "spline": filled["spline"]}
motions = [motion.resample(30) for motion in shown.values()]
player(motions, labels=list(shown), overlay=True, title="in-betweens")
