"""
One's own BVH files
===================

From a drawer of BVH files to distances between the poses in them, and back to a file that Blender opens. The files here
are made up and written first; put your own folder in their place.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from skpose import Motion, Skeleton, geodesic, pose_distances
from skpose.datasets import make_gait
from skpose.io import MocapFormatError, load_motion, save_bvh
from skpose.plot import DistanceMatrixDisplay, PoseStripDisplay

folder = Path(tempfile.mkdtemp())
made_up = make_gait(n_subjects=2, n_sequences=1, random_state=0)
for motion, who, what in zip(made_up, made_up.subjects, made_up.actions, strict=True):
    save_bvh(folder / f"{who}_{what}.bvh", motion, scale=0.01)  # in centimetres, as most are

# %%
# BVH has no unit of length, so say which: 0.01 m for centimetres. What a file gets wrong is said with line and column.
paths = sorted(folder.glob("*.bvh"))
motions = [load_motion(path, scale=0.01) for path in paths]
for path, motion in zip(paths, motions, strict=True):
    print(path.name, motion)
(folder / "cut.bvh").write_text(paths[0].read_text()[:5000])
try:
    load_motion(folder / "cut.bvh")
except MocapFormatError as error:
    print(error)

# %%
# A motion is a table of angles, with names.
print(motions[0].to_pandas().iloc[:3, :4].round(3))
PoseStripDisplay.from_motion(motions[0], view="zy")
plt.show()

# %%
# The poses of several people are compared on one body, the mean of theirs.
body = Skeleton.mean(motion.skeleton for motion in motions)
poses = [motion.retarget(body).resample(12).angles for motion in motions]
X, sequence = np.concatenate(poses), np.repeat(np.arange(len(poses)), [len(p) for p in poses])
DistanceMatrixDisplay.from_poses(X, body, sequence=sequence, names=[path.stem for path in paths])
plt.show()

# %%
# Back to a file: the shortest way between the two poses that are farthest apart, at ten poses a second.
D = pose_distances(X, skeleton=body)
i, j = np.unravel_index(D.argmax(), D.shape)
way = geodesic(X[i], X[j], body)
save_bvh(folder / "way.bvh", Motion(body, way.resample(20), frame_rate=10), scale=0.01)
print(f"{(folder / 'way.bvh').name}: {way.length:.2f} m, the straight line {D[i, j]:.2f} m")
PoseStripDisplay.from_geodesic(way, body, view="zy")
plt.show()
