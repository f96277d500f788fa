"""
Your own BVH files
==================

From a folder of BVH files to distances between their poses, and back to a file that Blender opens. The example first
writes files with generated motions; use your own folder instead.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from skpose import Motion, geodesic, pose_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.io import MocapFormatError, load_motion, save_bvh
from skpose.plot import DistanceMatrixDisplay, PoseDisplay
from skpose.view import player

folder = Path(tempfile.mkdtemp())
generated = make_gait(n_subjects=2, n_sequences=1, random_state=0)
for motion, subject, action in zip(generated, generated.subjects, generated.actions, strict=True):
    save_bvh(folder / f"{subject}_{action}.bvh", motion, scale=0.01)  # in centimetres, like most files

# %%
# BVH has no unit of length, so pass one: 0.01 m for centimetres. An error in a file is reported with line and column.
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
# A motion is a table of angles with named columns.
print(motions[0].to_pandas().iloc[:3, :3].round(3))
PoseDisplay.from_motion(motions[0], projection="zy")
plt.show()

# %%
# The player shows at once whether up axis, sides and units are right.
player([motion.resample(30) for motion in motions], labels=[path.stem for path in paths], title="four files")

# %%
# Compare the poses of several people on their mean skeleton, whose joints are ball joints.
dataset = MotionDataset(motions)
X, sequence = dataset.poses(frame_rate=12)
skeleton = dataset.skeleton
DistanceMatrixDisplay.from_poses(X, skeleton, sequence=sequence, names=[path.stem for path in paths])
plt.show()

# %%
# Write a file: the shortest path between the two farthest poses, at ten poses a second.
D = pose_distances(X, skeleton=skeleton)
i, j = np.unravel_index(D.argmax(), D.shape)
shortest = geodesic(X[i], X[j], skeleton)
save_bvh(folder / "shortest.bvh", Motion(skeleton, shortest.resample(20), frame_rate=10), scale=0.01)
print(f"shortest.bvh: {shortest.length:.2f} m, the straight line {D[i, j]:.2f} m")
PoseDisplay.from_geodesic(shortest, skeleton, projection="zy")
plt.show()
