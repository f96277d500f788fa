"""
The typical stride, and the typical squat
=========================================

`segment_repetitions` finds where a movement repeats in a recording. `mean_motion` makes one typical motion of the
repetitions, whose bones keep their lengths, and says how much each joint varies in each phase. Closed to a cycle, it
can be repeated, and goes on walking. If SKPOSE_HDM05 names a folder of the database HDM05, the typical squat of one
person is the second part.
"""

# sphinx_gallery_tile = (3, 1)

import os
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from skpose import pose_distances
from skpose.datasets import load_hdm05, make_gait
from skpose.motions import align_motions, mean_motion, segment_repetitions
from skpose.plot import DistanceMatrixDisplay, PoseDisplay
from skpose.view import player

# %%
# A generated walk of eight seconds. Generated people walk on the spot: here they stand on the lowest point of their
# feet, and this moves the root.
FEET = ["left_foot", "left_toes", "right_foot", "right_toes"]


def feet_of(motion):
    """Return the positions (n_frames, 4, 3) of the joints of the feet."""
    return motion.positions()[:, [motion.skeleton.joint_names.index(name) for name in FEET]]


def walk_on_floor(motion):
    """Return the motion with a root that moves so that the lowest joint of the feet stands on the floor."""
    feet = feet_of(motion)
    frames, lowest = np.arange(len(motion)), feet[..., 1].argmin(axis=1)
    steps = feet[frames[:-1], lowest[:-1]] - feet[frames[1:], lowest[:-1]]
    places = np.concatenate([np.zeros((1, 3)), steps.cumsum(axis=0)])
    places[:, 1] = -feet[frames, lowest, 1]
    return replace(motion, root_positions=places)


walk = walk_on_floor(make_gait(1, 1, activities=["walk"], duration=8, frame_rate=30, random_state=0)[0])

# %%
# Its strides, from its own distance matrix:
strides = segment_repetitions(walk, metric="position")
print(strides)
for start, stop, distance in zip(strides.starts, strides.stops, strides.distances, strict=True):
    print(f"{start / 30:.2f} s to {stop / 30:.2f} s, {100 * distance:.0f} cm from the template")

# %%
# In the matrix a repetition is a dark line parallel to the diagonal. White lines are drawn where strides begin.
stride = np.searchsorted(strides.starts, np.arange(len(walk)), side="right")
names = ["before", *map(str, range(1, len(strides) + 1))][stride[0] :]
D = pose_distances(walk.angles, skeleton=walk.skeleton, metric="position")
DistanceMatrixDisplay.from_distances(D, sequence=stride, names=names)
plt.show()

# %%
# The first poses of the strides are one phase of the movement.
PoseDisplay.from_poses(
    walk.angles[strides.starts], walk.skeleton, labels=range(1, len(strides) + 1), title="stride", projection="zy"
)
plt.show()

# %%
# The typical stride.
mean = mean_motion(strides.motions)
print(mean)
PoseDisplay.from_motion(mean.to_motion(), n_poses=9, projection="zy")
plt.show()

# %%
# In the player, with the stride that differs most from the template: colours show by how much each joint differs.
pair = [mean.to_motion(), strides.motions[strides.distances.argmax()]]
player(pair, labels=["typical stride", "one stride"], alignment=align_motions(*pair), title="two strides")

# %%
# The mean has the movement of the root too. As a cycle, its last frame is its first one, moved along the floor: so it
# can be repeated, and written for other programs by `skpose.io.save_bvh`. Each foot stands still while the other one
# swings, across the seams (dashed) too.
cycle = mean.to_motion().to_cycle()
loop = cycle.repeat(3)
travel = cycle.root_positions[-1] - cycle.root_positions[0]
print(f"a stride takes {cycle.times[-1]:.2f} s and goes {100 * travel[2]:.0f} cm forward: {loop}")
feet, seams = feet_of(loop), cycle.times[-1] * np.arange(1, 3)
figure, (above, below) = plt.subplots(2, 1, figsize=(9, 7), sharex=True, layout="constrained")
above.plot(loop.times, loop.root_positions[:, 2], color="black", label="root")
for foot, colour in ((0, "#0072b2"), (2, "#e69f00")):
    above.plot(loop.times, feet[:, foot, 2], color=colour, label=FEET[foot].replace("_", " "))
    below.plot(loop.times, 100 * feet[:, foot, 1], color=colour)
for axes in (above, below):
    axes.vlines(seams, *axes.get_ylim(), color="#999999", linestyle="dashed")
above.set(ylabel="forward (m)", title="the typical stride, three times")
above.legend()
below.set(xlabel="time (s)", ylabel="height (cm)")
plt.show()

# %%
player(loop, title="the typical stride, three times")

# %%
# How much the strides vary: the joints at the ends of the limbs most.


def draw_variation(mean):
    """Draw the standard deviation of every joint, cm, against the time of the mean."""
    figure, ax = plt.subplots(figsize=(8, 5), layout="constrained")
    image = ax.imshow(
        100 * mean.joint_std.T, aspect="auto", extent=(0, len(mean) / mean.frame_rate, len(mean.skeleton), 0)
    )
    ax.set(xlabel="time of the mean (s)", yticks=np.arange(len(mean.skeleton)) + 0.5, yticklabels=mean.skeleton)
    figure.colorbar(image, label="standard deviation (cm)")


draw_variation(mean)
plt.show()

# %%
# The typical squat of one person of HDM05, from recordings of one repetition each. The root is at the origin, so
# the feet rise. Arms and knees vary most where the squat is deepest.
folder = os.environ.get("SKPOSE_HDM05")
if folder:
    dataset = load_hdm05(folder)
    chosen = (dataset.actions == "squat") & (dataset.subjects == "bd")
    squat = mean_motion([motion.resample(30) for motion in dataset[chosen]])
    print(f"{chosen.sum()} squats: {squat}")
    PoseDisplay.from_motion(squat.to_motion(), n_poses=9, projection="zy")
    draw_variation(squat)
    plt.show()
