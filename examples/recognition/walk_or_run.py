"""
Walking or running?
===================

Section 3.3 of the paper, from motions to a cross-validated classifier: read them, convert all poses to one skeleton,
and classify by the nearest neighbour, once for each metric, on sequences and people outside the training data. If
SKPOSE_CMU names a folder of CMU files, the example runs on these.
"""

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.model_selection import LeaveOneGroupOut, cross_val_predict, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import pose_distances
from skpose.datasets import load_cmu, make_gait, walks_and_runs
from skpose.preprocessing import PoseDistanceTransformer

folder = os.environ.get("SKPOSE_CMU")
angles = "file"  # as in the paper: Euler angles instead of ball joints
dataset = load_cmu(folder, rotations=angles) if folder else make_gait(rotations=angles, random_state=0)
dataset = walks_and_runs(dataset)
print(dataset)

# %%
# Poses at the paper's 12 Hz, on the mean skeleton of all subjects; their actions and subjects.
X, sequence = dataset.poses(frame_rate=12)
y, subject = dataset.actions[sequence], dataset.subjects[sequence]

# %%
# The distances to the training poses are a step of a pipeline like any other.
distances = PoseDistanceTransformer(dataset.skeleton, metric="spatial")
classifier = make_pipeline(distances, KNeighborsClassifier(n_neighbors=1, metric="precomputed"))
scores = cross_val_score(classifier, X, y, groups=subject, cv=LeaveOneGroupOut())
print(f"leave one subject out, spatial: {scores.mean():.1%} (worst subject {scores.min():.1%})")

# %%
# A matrix of distances serves any number of validations. The paper leaves sequences out, of people who are
# in the training data with others; frames of one sequence are nearly the same pose, so sequences stay whole.
nearest = KNeighborsClassifier(n_neighbors=1, metric="precomputed")
for metric in ("angle", "position", "rotation", "spatial"):
    D = pose_distances(X, skeleton=dataset.skeleton, metric=metric, n_jobs=-1)
    for left_out, groups in (("sequence", sequence), ("person", subject)):
        right = cross_val_predict(nearest, D, y, groups=groups, cv=LeaveOneGroupOut()) == y
        print(f"{metric:<10}leave one {left_out:<9} out: {right.mean():.1%} of the poses right")

# %%
# How clear is it? Each pose by its spatial distances to the nearest walking and to the nearest running pose of other
# people. On the line they are equal, and far from it a pose is clearly one of the two.
of_others = np.where(subject[:, None] == subject, np.inf, D)
to_walk, to_run = (of_others[:, y == action].min(axis=1) for action in ("walk", "run"))
figure, ax = plt.subplots(figsize=(6, 5), layout="constrained")
for action, colour, marker in (("walk", "#0072b2", "o"), ("run", "#d55e00", "^")):
    ax.scatter(to_walk[y == action], to_run[y == action], s=12, color=colour, marker=marker, alpha=0.7, label=action)
ax.axline((0, 0), slope=1, color="black", linewidth=1)
ax.set(xlabel="distance to the nearest walking pose (m)", ylabel="distance to the nearest running pose (m)")
ax.legend(title="the pose is of a")
ax.set_aspect("equal")
plt.show()
