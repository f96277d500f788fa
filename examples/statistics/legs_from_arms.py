"""
From the arms to the legs
=========================

How far the left foot is ahead of the right, predicted from the upper part of the skeleton alone, for people outside the
training data. Metrics, weights of joints and parts of the skeleton are parameters of a grid search. If SKPOSE_CMU names
a folder of CMU files, the example runs on these.
"""

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut
from sklearn.neighbors import KNeighborsRegressor
from sklearn.pipeline import Pipeline

from skpose import forward_kinematics
from skpose.datasets import MotionDataset, load_cmu, make_gait, walks_and_runs
from skpose.preprocessing import PoseDistanceTransformer

folder = os.environ.get("SKPOSE_CMU")
dataset = walks_and_runs(load_cmu(folder) if folder else make_gait(random_state=0))
walks = dataset[dataset.actions == "walk"]
X, sequence = walks.poses(frame_rate=8)
person = walks.subjects[sequence]
print(f"{walks}: {len(X)} poses")

# %%
# The quantity to predict, m. The axis z points ahead.
joints = walks.skeleton.joint_names
left, right = (
    next(joints.index(name) for name in (f"{side}_foot", f"{side[0]}foot") if name in joints)
    for side in ("left", "right")
)
positions = forward_kinematics(X, walks.skeleton)
y = positions[:, left, 2] - positions[:, right, 2]

# %%
# The upper part. `select` drops the columns of the legs, and keeps weights: "mass" is computed for the whole skeleton,
# as the table that it comes from has all segments of a person.
hips = [name for name in joints if name.endswith(("pelvis", "hipjoint"))]
upper = walks.select(drop=hips)
X, _ = upper.poses(frame_rate=8)
skeleton = upper.skeleton
hands = [name for name in skeleton if any(part in name for part in ("hand", "finger", "thumb"))]
arms = [name for name in skeleton if any(part in name for part in ("arm", "humerus", "radius", "wrist"))]
skeletons = {
    "all joints": skeleton,
    "mass": walks.skeleton.with_weights("mass").select(drop=hips),
    "without hands": skeleton.with_weights(dict.fromkeys(hands, 0)),
    "arms without hands": skeleton.with_weights({name: 1 if name in arms else 0 for name in skeleton}),
}

# %%
# All skeletons of the grid have the same columns: a joint of weight zero is not seen, but its columns stay. So the same
# X fits all of them. "angle" sees no weights.
pipeline = Pipeline(
    [
        ("distances", PoseDistanceTransformer()),
        ("regressor", KNeighborsRegressor(10, metric="precomputed")),
    ]
)
metrics = ["angle", "position", "rotation", "spatial"]
grid = {"distances__metric": metrics, "distances__skeleton": list(skeletons.values())}
search = GridSearchCV(pipeline, grid, cv=LeaveOneGroupOut()).fit(X, y, groups=person)
scores = search.cv_results_["mean_test_score"].reshape(len(metrics), len(skeletons))  # the skeleton varies faster
row, column = np.unravel_index(scores.argmax(), scores.shape)
print(f"best: {metrics[row]}, {list(skeletons)[column]}; R² {scores.max():.2f}, mean over the people left out")

figure, ax = plt.subplots(figsize=(8, 4), layout="constrained")
image = ax.imshow(scores, vmin=min(0, scores.min()), vmax=1, aspect="auto")
ax.set_xticks(range(len(skeletons)), list(skeletons))
ax.set_yticks(range(len(metrics)), metrics)
for (i, j), score in np.ndenumerate(scores):
    ax.text(j, i, f"{score:.2f}", ha="center", va="center", color="white" if score < 0.6 else "black")
figure.colorbar(image, label="R², mean over the people left out")
plt.show()

# %%
# Motions of one person alone, and with their mirror images: twice the data. What was ahead is then behind.
mirrored, _ = MotionDataset([motion.mirrored() for motion in upper]).poses(frame_rate=8, skeleton=skeleton)
best = search.best_estimator_
for name in np.unique(person):
    known = person == name
    alone = best.fit(X[known], y[known]).score(X[~known], y[~known])
    twice = best.fit(np.concatenate([X[known], mirrored[known]]), np.concatenate([y[known], -y[known]]))
    print(f"trained on {name} alone: R² {alone:.2f}; and mirrored: {twice.score(X[~known], y[~known]):.2f}")
