"""
The typical stride, and the typical squat
=========================================

`segment_repetitions` finds where a movement repeats in a recording. `mean_motion` makes one typical motion of the
repetitions, whose bones keep their lengths, and says how much each joint varies in each phase. If SKPOSE_HDM05 names a
folder of the database HDM05, the typical squat of one person is the second part.
"""

import os

import matplotlib.pyplot as plt
import numpy as np

from skpose import pose_distances
from skpose.datasets import load_hdm05, make_gait
from skpose.motions import align_motions, mean_motion, segment_repetitions
from skpose.plot import DistanceMatrixDisplay, MeanMotionDisplay, PoseStripDisplay
from skpose.view import player

# %%
# A generated walk of eight seconds. Its strides, from its own distance matrix:
walk = make_gait(1, 1, activities=["walk"], duration=8, frame_rate=30, random_state=0)[0]
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
PoseStripDisplay.from_poses(
    walk.angles[strides.starts], walk.skeleton, labels=range(1, len(strides) + 1), title="stride", projection="zy"
)
plt.show()

# %%
# The typical stride.
mean = mean_motion(strides.motions)
print(mean)
PoseStripDisplay.from_motion(mean.to_motion(), n_poses=9, projection="zy")
plt.show()

# %%
# In the player, with the stride that differs most from the template: colours show by how much each joint differs.
pair = [mean.to_motion(), strides.motions[strides.distances.argmax()]]
player(pair, labels=["typical stride", "one stride"], alignment=align_motions(*pair), title="two strides")

# %%
# How much the strides vary: the joints at the ends of the limbs most.
MeanMotionDisplay.from_mean(mean)
plt.show()

# %%
# The typical squat of one person of HDM05, from recordings of one repetition each. The root is at the origin, so
# the feet rise. Arms and knees vary most where the squat is deepest.
folder = os.environ.get("SKPOSE_HDM05")
if folder:
    dataset = load_hdm05(folder)
    chosen = (dataset.actions == "squat") & (dataset.subjects == "bd")
    squat = mean_motion([motion.to_rotvec().resample(30) for motion in dataset[chosen]])
    print(f"{chosen.sum()} squats: {squat}")
    PoseStripDisplay.from_motion(squat.to_motion(), n_poses=9, projection="zy")
    MeanMotionDisplay.from_mean(squat)
    plt.show()
