"""
Poses from the hands and the feet
=================================

The whole pose is predicted from the positions of hands, feet and head alone, as a headset with trackers measures them,
for a person outside the training data. A model of joint positions breaks the bones; `PoseKernelRegressor` predicts
weighted means of poses, which are poses. The width of its kernel is a parameter of a grid search. If SKPOSE_CMU names a
folder of CMU files, the example runs on these.
"""

# sphinx_gallery_tile = (1, 2)

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.model_selection import GridSearchCV, GroupKFold
from sklearn.neighbors import KNeighborsRegressor

from skpose import forward_kinematics
from skpose.datasets import load_cmu, make_gait, walks_and_runs
from skpose.plot import PoseDisplay
from skpose.statistics import PoseKernelRegressor

folder = os.environ.get("SKPOSE_CMU")
dataset = walks_and_runs(load_cmu(folder) if folder else make_gait(5, 1, random_state=0))
y, sequence = dataset.poses(frame_rate=8)
skeleton, person = dataset.skeleton, dataset.subjects[sequence]
print(f"{dataset}: {len(y)} poses")

# %%
# The features: positions of five joints relative to the root, 15 numbers.
positions = forward_kinematics(y, skeleton)
ends = [name for name in skeleton.joint_names if name.endswith(("hand", "foot", "head"))]
X = positions[:, [skeleton.joint_names.index(name) for name in ends]].reshape(len(y), -1)
print("features:", ", ".join(ends))

# %%
# The kernel's width and the number of neighbours, searched for among the people of the training data. The score is the
# share of the variance of the joint positions that the poses explain.
known = person != np.unique(person)[-1]
grid = {"gamma": [10.0, 30.0, 100.0, 300.0], "n_neighbors": [5, None]}
search = GridSearchCV(PoseKernelRegressor(skeleton), grid, cv=GroupKFold(2))
search.fit(X[known], y[known], groups=person[known])
print(f"best: {search.best_params_}, share of variance {search.score(X[~known], y[~known]):.2f} for a new person")

# %%
# Next to neighbours whose joint positions are averaged: nearly the same error, but other bones in every frame.
poses = forward_kinematics(search.predict(X[~known]), skeleton)
flat = positions.reshape(len(y), -1)
neighbours = KNeighborsRegressor(10).fit(X[known], flat[known])
averages = neighbours.predict(X[~known]).reshape(poses.shape)


def bone_lengths(joints):
    """Return the lengths of all bones (n_poses, n_joints), m."""
    with_root = np.concatenate([joints, np.zeros((len(joints), 1, 3))], axis=1)  # the last is the root, at index -1
    return np.linalg.norm(joints - with_root[:, skeleton.parents], axis=2)


figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
exact = np.linalg.norm(skeleton.offsets, axis=1)
for title, joints in (("PoseKernelRegressor", poses), ("KNeighborsRegressor of positions", averages)):
    error = 100 * np.linalg.norm(joints - positions[~known], axis=2).mean()
    change = 100 * np.abs(bone_lengths(joints) - exact).max(axis=1)
    print(f"{title}: mean error {error:.1f} cm, bones change by up to {change.max():.1f} cm")
    axes[0].plot(change, label=title)
axes[0].set(xlabel="frame of the new person", ylabel="largest change of a bone (cm)")
axes[0].set_ylim(top=1.3 * axes[0].get_ylim()[1])
axes[0].legend(loc="upper left")
worst = np.abs(bone_lengths(averages) - exact).max(axis=1).argmax()
shown = (
    ("true pose", positions[~known], "0.6"),
    ("predicted pose", poses, "C0"),
    ("mean of positions", averages, "C1"),
)
for title, joints, color in shown:
    PoseDisplay.from_positions(joints[worst], skeleton, ax=axes[1], projection="zy", color=color, label=title)
axes[1].set_title("the frame of the largest change")
axes[1].legend()
plt.show()
