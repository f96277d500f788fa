"""
Matrices larger than memory
===========================

Distances between more poses than fit into a matrix in memory: chunk by chunk, on disk, and in other processes. If
SKPOSE_CMU names a folder of CMU files, the example runs on these.
"""

# sphinx_gallery_tile = (2, 1)

import os
import tempfile
from pathlib import Path

import joblib
import matplotlib.pyplot as plt
import numpy as np

from skpose import PoseKNeighborsTransformer, pose_distances
from skpose.datasets import load_cmu, make_gait
from skpose.metrics import pose_distances_chunked
from skpose.plot import DistanceMatrixDisplay, PoseDisplay

folder = os.environ.get("SKPOSE_CMU")
dataset = load_cmu(folder) if folder else make_gait(random_state=0)
X, sequence = dataset.poses(frame_rate=12)
X, skeleton = X[:2000].astype(np.float32), dataset.skeleton
print(f"{len(X)} poses")

# %%
# The typical pose of all is the medoid, the one with the least sum of distances. The sums need no matrix: each chunk of
# rows, as large as `working_memory` (MiB) allows, is reduced to its sums.
sums = pose_distances_chunked(
    X, skeleton=skeleton, reduce_func=lambda chunk, start: chunk.sum(axis=1), working_memory=2
)
medoid = int(np.concatenate(list(sums)).argmin())
print(f"the medoid is a pose of a {dataset.actions[sequence[medoid]]}")
PoseDisplay.from_pose(X[medoid], skeleton, projection="zxy")
plt.show()

# %%
# A matrix on disk is written tile by tile, and never as a whole in memory.
with tempfile.TemporaryDirectory() as scratch:
    path = Path(scratch, "D.npy")
    out = np.lib.format.open_memmap(path, mode="w+", dtype=X.dtype, shape=(len(X), len(X)))
    pose_distances(X, skeleton=skeleton, out=out, n_jobs=-1)
    print(f"{path.name}: {path.stat().st_size / 1e6:.0f} MB, mean distance {out.mean():.2f} m")
    n = np.searchsorted(sequence, 8)
    corner = np.array(out[:n, :n])  # of the first eight motions: a picture need not load the rest
    del out
DistanceMatrixDisplay.from_distances(corner, sequence=sequence[:n], names=dataset.actions[:8])
plt.show()

# %%
# skpose works in the backend that joblib is configured for: here two processes, likewise a cluster with
# ``backend="dask"`` and a ``dask.distributed.Client``. The result is the same to the last bit.
search = PoseKNeighborsTransformer(skeleton, n_neighbors=5).fit(X)
distances, indices = search.kneighbors()
with joblib.parallel_config(backend="loky", n_jobs=2):
    in_processes = search.kneighbors()
same = np.array_equal(in_processes[0], distances) and np.array_equal(in_processes[1], indices)
print(f"two processes find {'the same' if same else 'other'} neighbours")
