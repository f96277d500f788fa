"""
Who walks? Votes of frames
==========================

A support vector machine with a kernel of distances recognises people by their legs, frame by frame. The frames of a
sequence then vote. If SKPOSE_CMU names a folder of CMU files, the example runs on these.
"""

# sphinx_gallery_tile = (1, 3)

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.model_selection import GroupKFold, cross_val_predict
from sklearn.pipeline import make_pipeline
from sklearn.svm import SVC

from skpose.datasets import load_cmu, make_gait, walks_and_runs
from skpose.preprocessing import PoseDistanceTransformer

folder = os.environ.get("SKPOSE_CMU")
dataset = walks_and_runs(load_cmu(folder) if folder else make_gait(random_state=0))
walks = dataset[dataset.actions == "walk"]
names, counts = np.unique(walks.subjects, return_counts=True)
walks = walks[np.isin(walks.subjects, names[counts > 1])]  # one recording to learn from, one to recognise
names = np.unique(walks.subjects)

# %%
# The legs alone: `select` keeps the feet and the joints that carry them. Folds keep sequences whole.
legs = walks.select([name for name in walks.skeleton if name.endswith("foot")])
X, sequence = legs.poses(frame_rate=4)
person = legs.subjects[sequence]
print(f"{legs}: {len(X)} poses, {legs.skeleton.n_dofs} degrees of freedom")

# %%
# The kernel exp(−γd²) of "rotation", "spatial" and "geodesic" may have negative eigenvalues, with which an SVM may stop
# at a point that is not optimal. ``psd="clip"`` removes them in `fit`, and repairs the rows of new poses consistently.
# The share of votes says how sure a vote is.
shares = {}
for metric in ("angle", "rotation", "spatial"):
    kernel = PoseDistanceTransformer(legs.skeleton, metric=metric, kernel="rbf", psd="clip")
    machine = make_pipeline(kernel, SVC(kernel="precomputed", class_weight="balanced"))
    predicted = cross_val_predict(machine, X, person, groups=sequence, cv=GroupKFold(4))
    votes = np.array([[np.mean(predicted[sequence == i] == name) for name in names] for i in range(len(legs))])
    winners = names[votes.argmax(axis=1)]
    shares[metric] = votes
    print(
        f"{metric:<10}{np.mean(predicted == person):.1%} of the frames, {np.mean(winners == legs.subjects):.1%} of the "
        f"sequences right; negative eigenvalues {kernel.fit(X).negative_share_:.4%}"
    )

# %%
# The votes. "angle" and "rotation" are better here: people differ more in how their legs are turned than in where their
# joints are.
order = np.argsort(legs.subjects, kind="stable")
figure, axes = plt.subplots(1, len(shares), figsize=(11, 5), sharey=True, layout="constrained")
for ax, (metric, votes) in zip(axes, shares.items(), strict=True):
    image = ax.imshow(votes[order], vmin=0, vmax=1, aspect="auto", interpolation="nearest")
    ax.set_xticks(range(len(names)), names)
    ax.set_yticks(range(len(legs)), legs.subjects[order])
    ax.set(title=f"“{metric}”", xlabel="person recognised")
axes[0].set_ylabel("sequence, by its person")
figure.colorbar(image, label="share of votes")
plt.show()
