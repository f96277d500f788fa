"""
Classify whole motions
======================

A pose alone does not say whether a person walks or runs, sits down or stands up; the whole motion does. Dynamic time
warping compares motions of different lengths and tempos, with a distance between poses as the cost of each pair of
frames. The nearest motion among other people then names the action. If SKPOSE_HDM05 names a folder of files of HDM05,
the example runs on these.
"""

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.model_selection import LeaveOneGroupOut, cross_val_predict
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import motion_distances
from skpose.datasets import load_hdm05, make_gait
from skpose.manifold import SpatialMDS
from skpose.motions import MotionKNeighborsTransformer
from skpose.plot import DistanceMatrixDisplay, MDSDisplay

folder = os.environ.get("SKPOSE_HDM05")
dataset = load_hdm05(folder) if folder else make_gait(n_subjects=5, n_sequences=3, random_state=0)
print(dataset)

# %%
# Twelve frames a second. What is classified is a list of motions, whose lengths differ.
motions = [motion.resample(12) for motion in dataset]
if not folder:  # generated recordings are equally long: let them end at different times
    ends = np.random.default_rng(0).integers(18, 37, size=len(motions))
    motions = [motion[:end] for motion, end in zip(motions, ends, strict=True)]
lengths = [len(motion) for motion in motions]
print(f"{len(motions)} motions of {min(lengths)} to {max(lengths)} frames")

# %%
# One person after another is left out. The skeleton on which motions are compared is the mean of the people that are
# left: `MotionKNeighborsTransformer` learns it in `fit`. It finds the nearest motions, and aligns few of the others.
for metric in ("angle", "position", "rotation", "spatial"):
    nearest = make_pipeline(
        MotionKNeighborsTransformer(n_neighbors=1, metric=metric, n_jobs=-1),
        KNeighborsClassifier(1, metric="precomputed"),
    )
    actions = cross_val_predict(nearest, motions, dataset.actions, groups=dataset.subjects, cv=LeaveOneGroupOut())
    print(f"{metric:<10}{np.mean(actions == dataset.actions):.1%} of the motions recognised")

# %%
# The distances of all motions in the plane, and as a matrix with the motions of an action next to each other.
D = motion_distances(motions, n_jobs=-1)
order = np.argsort(dataset.actions, kind="stable")
names, action = np.unique(dataset.actions, return_inverse=True)

figure, axes = plt.subplots(1, 2, figsize=(14, 6), layout="constrained")
mds = SpatialMDS(n_components=2, metric="precomputed").fit(D)
MDSDisplay.from_estimator(mds, D, dataset.actions, ax=axes[0], s=30)
axes[0].legend(title="action", loc="center left", bbox_to_anchor=(1, 0.5))
DistanceMatrixDisplay(D[np.ix_(order, order)], action[order], names).plot(axes[1])
plt.show()
