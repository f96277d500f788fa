"""
The shortest path from pose to pose
===================================

Figure 3 of the paper: how well does the straight line in angle space, whose length is the "spatial" distance,
approximate the shortest path, the geodesic? (a) Both for two poses of a walk, in the first two principal components of
their points, over the trace of the metric tensor: dark where the joints move far. (b) The ratio of their lengths for
100 random pairs, eq. 8. If SKPOSE_CMU names a folder of CMU files, the example runs on the walks of its subject 35.
"""

# sphinx_gallery_tile = (1, 1)

import os

import matplotlib.pyplot as plt
import numpy as np

from skpose import geodesic, pose_distances
from skpose.datasets import load_cmu, make_gait
from skpose.plot import GeodesicDisplay, PoseDisplay
from skpose.view import player

folder = os.environ.get("SKPOSE_CMU")
angles = "file"  # as in the paper: Euler angles instead of ball joints
dataset = load_cmu(folder, rotations=angles) if folder else make_gait(rotations=angles, random_state=0)
dataset = dataset[(dataset.actions == "walk") & ((dataset.subjects == "35") | (folder is None))]
skeleton = dataset.skeleton
X, sequence = dataset.poses(frame_rate=12)
print(dataset)

# %%
# 100 pairs, each of one sequence.
rng = np.random.default_rng(0)
pairs = [rng.choice(np.flatnonzero(sequence == i), 2, replace=False) for i in rng.integers(len(dataset), size=100)]
geodesics = [geodesic(X[i], X[j], skeleton) for i, j in pairs]
lines = np.array([pose_distances(X[[i]], X[[j]], skeleton=skeleton)[0, 0] for i, j in pairs])
ratios = np.array([path.length for path in geodesics]) / lines
print(f"length of the geodesic over that of the line: lowest {ratios.min():.3f}, median {np.median(ratios):.3f}")

# %%
# The pair of lowest ratio, and all ratios. Angles that move the joints very little cost very little: the geodesic may
# be far from the line and only a little shorter.
worst = int(ratios.argmin())
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
GeodesicDisplay.from_geodesic(geodesics[worst], skeleton, ax=left)
left.set_title(f"(a) the pair of lowest ratio, {ratios[worst]:.3f}")
right.hist(ratios, bins=20, color="#0072b2")
right.axvline(ratios.min(), color="#d55e00", linestyle="--")
note = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "color": "#d55e00"}
right.annotate(f"lowest, {ratios.min():.3f}", (ratios.min(), 0.9), (6, 0), **note)
right.set(xlabel="length of the geodesic / length of the line", ylabel="pairs of poses")
right.set_title("(b) 100 pairs of walking poses")
plt.show()

# %%
# The path itself, at constant speed.
PoseDisplay.from_geodesic(geodesics[worst], skeleton, projection="zy")
plt.show()

# %%
# The path and the straight line in the player.
player(geodesics[worst])
