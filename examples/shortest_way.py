"""
The shortest way from pose to pose
==================================

Figure 3 of the paper: how good is the straight line in angle space, whose length is the "spatial" distance, as a
stand-in for the geodesic? (a) Both for two poses of a walk, in the first two principal components of their points, over
the trace of the metric tensor. (b) The ratio of their lengths for 100 random pairs, eq. 8. With SKPOSE_CMU naming a
folder of CMU files, on the walks of its subject 35.
"""

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.decomposition import PCA

from skpose import geodesic, metric_tensor, pose_distances
from skpose.datasets import load_cmu, make_gait

folder = os.environ.get("SKPOSE_CMU")
dataset = load_cmu(folder) if folder else make_gait(random_state=0)
dataset = dataset.select((dataset.actions == "walk") & ((dataset.subjects == "35") | (folder is None)))
skeleton = dataset.skeleton
X, sequence = dataset.poses(frame_rate=12)
print(dataset)

# %%
# 100 pairs, each of one sequence.
rng = np.random.default_rng(0)
pairs = [rng.choice(np.flatnonzero(sequence == i), 2, replace=False) for i in rng.integers(len(dataset), size=100)]
ways = [geodesic(X[i], X[j], skeleton) for i, j in pairs]
lines = np.array([pose_distances(X[[i]], X[[j]], skeleton=skeleton)[0, 0] for i, j in pairs])
ratios = np.array([way.length for way in ways]) / lines
print(f"length of the geodesic over that of the line: lowest {ratios.min():.3f}, median {np.median(ratios):.3f}")

# %%
# The pair whose line is least good, in the plane of most variance of the points of line and geodesic.
worst = ratios.argmin()
i, j = pairs[worst]
path = ways[worst].path
line = np.linspace(path[0], path[-1], len(path))
plane = PCA(2).fit(np.concatenate([path, line]))
points = plane.transform(np.concatenate([path, line]))
margin = 0.2 * np.ptp(points, axis=0)
x, y = np.linspace(points.min(axis=0) - margin, points.max(axis=0) + margin, 60).T
grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
trace = np.trace(metric_tensor(plane.inverse_transform(grid), skeleton), axis1=1, axis2=2).reshape(len(y), len(x))

# %%
# Angles that hardly move a joint cost hardly anything: the geodesic may leave the line widely and be little shorter.
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
image = left.pcolormesh(x, y, trace, cmap="Greys", shading="gouraud")
figure.colorbar(image, ax=left, label="trace of the metric tensor (m²/rad²)")
left.plot(*plane.transform(line).T, "o--", color="#0072b2", label="straight line in angle space")
left.plot(*plane.transform(path).T, "o-", color="#d55e00", label="geodesic")
left.set(xlabel="first principal component (rad)", ylabel="second principal component (rad)")
left.set_title(f"(a) the least good line, ratio {ratios[worst]:.3f}")
right.hist(ratios, bins=20, color="#0072b2")
right.axvline(ratios.min(), color="#d55e00", label=f"lowest ratio, {ratios.min():.3f}")
right.set(xlabel="length of the geodesic / length of the line", ylabel="pairs of poses")
right.set_title("(b) 100 pairs of walking poses")
figure.legend(loc="outside lower center", ncols=3)
plt.show()
