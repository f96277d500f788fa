"""
Clusters of poses
=================

Section 3.4 of the paper: a walk and a run, clustered by medoid shift at a bandwidth that gives two clusters. The
centre of each cluster is a pose of the data, which can be drawn. K-means has means as centres, which are poses too. If
SKPOSE_CMU names a folder of CMU files, the example runs on these.
"""

# sphinx_gallery_tile = (1, 4)

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.metrics import adjusted_rand_score

from skpose.cluster import MedoidShift, PoseKMeans
from skpose.datasets import load_cmu, make_gait, walks_and_runs
from skpose.manifold import SpatialMDS
from skpose.plot import MDSDisplay, PoseDisplay

folder = os.environ.get("SKPOSE_CMU")
angles = "file"  # as in the paper: Euler angles instead of ball joints
dataset = load_cmu(folder, rotations=angles) if folder else make_gait(rotations=angles, random_state=0)
dataset = walks_and_runs(dataset)
pair = dataset[[int(np.flatnonzero(dataset.actions == action)[0]) for action in ("walk", "run")]]
X, sequence = pair.poses(frame_rate=12)
skeleton = pair.skeleton
print(pair)

# %%
# Two clusters, compared with walking and running.
figure, axes = plt.subplots(2, 2, figsize=(11, 8), layout="constrained")
for row, metric in zip(axes, ("angle", "spatial"), strict=True):
    shift = MedoidShift(skeleton, n_clusters=2, metric=metric).fit(X)
    agree = np.mean(shift.labels_ == sequence)
    print(f"{metric}: {max(agree, 1 - agree):.0%} of the poses in the right cluster, bandwidth {shift.bandwidth_:.2f}")
    print(f"    adjusted Rand index {adjusted_rand_score(sequence, shift.labels_):.2f}")
    embedding = SpatialMDS(skeleton, n_components=2, metric=metric).fit_transform(X)
    unit = "rad" if metric == "angle" else "m"
    for ax, title, labels in zip(row, ("actions", "clusters"), (pair.actions[sequence], shift.labels_), strict=True):
        MDSDisplay.from_embedding(embedding, labels, unit=unit, ax=ax)
        ax.set_title(f"“{metric}”: {title}")
plt.show()

# %%
# The centres of the clusters under the spatial distance.
PoseDisplay.from_poses(
    X[shift.cluster_centers_indices_], skeleton, labels=["cluster 0", "cluster 1"], title="medoids", projection="zy"
)
plt.show()

# %%
# K-means with two clusters separates the phases of the stride, left leg ahead or right, as joints move farther within a
# walk than between a walk and a run. With six clusters the centres are key poses, most of them of one action.
two = PoseKMeans(skeleton, n_clusters=2, random_state=0).fit(X)
print(f"k-means, 2 clusters: adjusted Rand index {adjusted_rand_score(sequence, two.labels_):.2f}")
k_means = PoseKMeans(skeleton, n_clusters=6, n_init=10, random_state=0).fit(X)
shares = [np.mean(pair.actions[sequence[k_means.labels_ == k]] == "run") for k in range(6)]
print(f"k-means, 6 clusters: inertia {k_means.inertia_:.1f} m², {k_means.n_iter_} iterations")
order = np.argsort(shares)
labels = [f"{shares[k]:.0%} run" for k in order]
PoseDisplay.from_poses(k_means.cluster_centers_[order], skeleton, labels=labels, title="k-means", projection="zy")
plt.show()
