"""
Which actions are confused
==========================

An accuracy does not say which motions are confused, nor why. scikit-learn's confusion matrix shows what was taken for
what, and `PoseDisplay` the motions themselves.

Whole recordings of generated gait are too easy to be confused. Here the task is made hard: noisy pieces of half a
second, less than a stride, forward and backward in time.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from sklearn.metrics import ConfusionMatrixDisplay
from sklearn.model_selection import LeaveOneGroupOut, cross_val_predict
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose.datasets import MotionDataset, make_gait
from skpose.motions import MotionKNeighborsTransformer, motion_distances
from skpose.plot import PoseDisplay

FRAME_RATE = 15  # Hz
NOISE = np.radians(4)

gait = make_gait(n_subjects=8, n_sequences=3, duration=2, frame_rate=FRAME_RATE, random_state=0)
rng = np.random.default_rng(0)


def cut(motion, step):
    """A noisy piece of 0.5 to 0.7 s from anywhere in a motion; step -1 reverses its frames."""
    n = rng.integers(8, 11)
    start = rng.integers(len(motion) - n)
    piece = motion[start : start + n]
    return replace(piece, angles=piece.angles[::step] + NOISE * rng.normal(size=piece.angles.shape))


pieces = [cut(motion, step) for motion in gait for step in (1, -1)]
actions = [f"{action}{word}" for action in gait.actions for word in ("", " backward")]
dataset = MotionDataset(pieces, subjects=np.repeat(gait.subjects, 2), actions=actions)
print(dataset)

# %%
# The nearest neighbour by dynamic time warping, leave-one-person-out. Rows of the matrix are the true classes.
nearest = make_pipeline(
    MotionKNeighborsTransformer(n_neighbors=1, metric="position"), KNeighborsClassifier(1, metric="precomputed")
)
predicted = cross_val_predict(nearest, dataset.motions, dataset.actions, groups=dataset.subjects, cv=LeaveOneGroupOut())
print(f"{np.mean(predicted == dataset.actions):.1%} of the motions recognised")
ConfusionMatrixDisplay.from_predictions(dataset.actions, predicted, xticks_rotation=30)
plt.show()

# %%
# A motion of the most frequent confusion, and below it the nearest motion of the class that it was taken for.
confusions = [pair for pair in zip(dataset.actions, predicted, strict=True) if pair[0] != pair[1]]
true, taken_for = max(set(confusions), key=confusions.count)
index = np.flatnonzero((dataset.actions == true) & (predicted == taken_for))[0]
others = np.flatnonzero((dataset.actions == taken_for) & (dataset.subjects != dataset.subjects[index]))
distances = motion_distances([pieces[index]], [pieces[i] for i in others], skeleton=dataset.skeleton, metric="position")
similar = others[distances[0].argmin()]
_, axes = plt.subplots(2, 1, figsize=(9, 6), layout="constrained")
for ax, i in zip(axes, (index, similar), strict=True):
    PoseDisplay.from_motion(pieces[i], n_poses=7, projection="zy", ax=ax)
    ax.set_title(f"{dataset.actions[i]}, person {dataset.subjects[i]}", loc="left")
plt.show()
