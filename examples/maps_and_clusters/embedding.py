"""
Poses in the plane
==================

Figure 4 of the paper: multidimensional scaling of two people's walks. Under the angle distance the two people are apart
(a); under the spatial distance both follow the same closed curve (b). (c) The share of variance in the first component,
for each sequence. If SKPOSE_CMU names a folder of CMU files, the example runs on these.
"""

# sphinx_gallery_tile = (1, 2)

import os

import matplotlib.pyplot as plt
import numpy as np

from skpose.datasets import load_cmu, make_gait
from skpose.manifold import SpatialMDS
from skpose.plot import DistanceMatrixDisplay, MDSDisplay

folder = os.environ.get("SKPOSE_CMU")
angles = "file"  # as in the paper: Euler angles instead of ball joints
dataset = load_cmu(folder, rotations=angles) if folder else make_gait(rotations=angles, random_state=0)
walks = dataset[dataset.actions == "walk"]
people = np.unique(walks.subjects)[:2]
both = walks[[int(np.flatnonzero(walks.subjects == person)[0]) for person in people]]
X, sequence = both.poses(frame_rate=12)
print(both)

# %%
# (a, b) The same poses under both distances.
figure, axes = plt.subplots(1, 3, figsize=(15, 4.5), layout="constrained")
for ax, letter, metric in zip(axes, "ab", ("angle", "spatial"), strict=False):
    mds = SpatialMDS(both.skeleton, n_components=2, metric=metric).fit(X)
    MDSDisplay.from_estimator(mds, X, both.subjects[sequence], ax=ax)
    ax.get_legend().set_title("person")
    ax.set_title(f"({letter}) “{metric}”")

# (c) Every sequence on its own.
for metric, colour in (("angle", "#0072b2"), ("spatial", "#d55e00")):
    shares = [
        SpatialMDS(motion.skeleton, n_components=1, metric=metric)
        .fit(motion.resample(12).angles)
        .explained_variance_ratio_[0]
        for motion in dataset
    ]
    axes[2].hist(shares, bins=np.linspace(0, 1, 21), color=colour, alpha=0.6, label=f"“{metric}”")
    print(f"{metric}: the first component has {np.median(shares):.0%} of a sequence's variance, in the median")
axes[2].set(xlabel="share of variance in the first component", ylabel="sequences", title="(c) all sequences")
axes[2].legend()
plt.show()

# %%
# The distances themselves. Steps appear as stripes; under the spatial distance also between people.
figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
for ax, metric in zip(axes, ("angle", "spatial"), strict=True):
    DistanceMatrixDisplay.from_poses(X, both.skeleton, sequence=sequence, names=both.subjects, metric=metric, ax=ax)
    ax.set_title(f"“{metric}”")
plt.show()
