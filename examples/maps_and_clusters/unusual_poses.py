"""
Unusual poses and clusters on one graph
=======================================

A graph of neighbours serves several estimators of scikit-learn. Here `LocalOutlierFactor` looks for faulty frames in
it, and `HDBSCAN` for clusters. If SKPOSE_CMU names a folder of CMU files, the example runs on these.
"""

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.cluster import HDBSCAN
from sklearn.metrics import adjusted_rand_score, roc_auc_score
from sklearn.neighbors import LocalOutlierFactor

from skpose import Motion, PoseKNeighborsTransformer
from skpose.datasets import load_cmu, make_gait, walks_and_runs
from skpose.plot import PoseDisplay

folder = os.environ.get("SKPOSE_CMU")
dataset = walks_and_runs(load_cmu(folder) if folder else make_gait(random_state=0))
X, sequence = dataset.poses(frame_rate=12)
skeleton = dataset.skeleton
print(f"{dataset}: {len(X)} poses")

# %%
# Thirty frames get a fault that happens: markers of the left leg are taken for those of the right, and the reverse. The
# legs are then those of the mirrored motion, and the rest of the skeleton stays.
hips = [name for name in skeleton if name.endswith(("pelvis", "hipjoint"))]
upper = skeleton.select(drop=hips).columns_in(skeleton)
legs = np.setdiff1d(np.arange(skeleton.n_dofs), upper)
faulty = np.random.default_rng(0).choice(len(X), 30, replace=False)
mirrored = Motion(skeleton, X, frame_rate=12).mirrored().angles
X[np.ix_(faulty, legs)] = mirrored[np.ix_(faulty, legs)]

# %%
# The graph of the 20 nearest neighbours. Each row is sorted, as `LocalOutlierFactor` needs it.
graph = PoseKNeighborsTransformer(skeleton, n_neighbors=20, n_jobs=-1).fit_transform(X)
outliers = LocalOutlierFactor(20, metric="precomputed").fit(graph)
factor = -outliers.negative_outlier_factor_
is_faulty = np.isin(np.arange(len(X)), faulty)
highest = np.argsort(-factor)[: len(faulty)]
print(f"{is_faulty[highest].sum()} of the {len(faulty)} highest factors are faulty frames")
print(f"area under the ROC curve {roc_auc_score(is_faulty, factor):.2f}")

figure, ax = plt.subplots(figsize=(8, 4), layout="constrained")
ax.scatter(np.flatnonzero(~is_faulty), factor[~is_faulty], s=4, color="0.6", label="as recorded")
ax.scatter(faulty, factor[faulty], s=20, color="#d55e00", label="legs exchanged")
ax.set(xlabel="frame", ylabel="local outlier factor")
ax.legend()
plt.show()

# %%
# The poses with the highest factors, from the side. Rare poses have high factors too, without a fault: in the files of
# CMU, the first steps of a walk on uneven terrain.
PoseDisplay.from_poses(
    X[highest[:8]],
    skeleton,
    labels=[f"{factor[i]:.2f}" for i in highest[:8]],
    title="local outlier factor",
    projection="zy",
)
plt.show()

# %%
# `HDBSCAN` needs a symmetric graph: two poses are neighbours if one is among the nearest of the other. It must be
# connected, with at least `min_samples` neighbours of each pose, itself not counted: `maximum` drops the zeros of the
# diagonal. ``copy=True`` leaves the graph as it is. Poses labelled −1 are in no cluster.
symmetric = graph.maximum(graph.T)
clusters = HDBSCAN(min_cluster_size=50, min_samples=10, metric="precomputed", copy=True).fit(symmetric)
labels, actions = clusters.labels_, dataset.actions[sequence]
for label in np.unique(labels):
    inside = labels == label
    counts = ", ".join(f"{np.sum(actions[inside] == action)} of a {action}" for action in np.unique(actions))
    print(f"cluster {label}: {counts}" if label >= 0 else f"no cluster: {counts}, {is_faulty[inside].sum()} faulty")
print(f"adjusted Rand index with walking and running {adjusted_rand_score(actions, labels):.2f}")
