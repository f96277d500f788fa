"""
Components of walking
=====================

Principal components of poses in the tangent space at their mean: each point of the space is a pose with bones of their
own length. The first components of walking are the stride itself, and how people differ in it. If SKPOSE_CMU names a
folder of CMU files, the example runs on the walks in it.
"""

# sphinx_gallery_tile = (2, 1)

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.decomposition import PCA

from skpose import forward_kinematics
from skpose.datasets import load_cmu, make_gait
from skpose.plot import PoseDisplay
from skpose.statistics import PoseTangentPCA

folder = os.environ.get("SKPOSE_CMU")
dataset = load_cmu(folder) if folder else make_gait(random_state=0)
walks = dataset[dataset.actions == "walk"]
skeleton = walks.skeleton
X, sequence = walks.poses(frame_rate=12)
people = walks.subjects[sequence]
print(walks)

# %%
# The last person is left out. Scores are in m: a score of 0.1 stands for joints that have moved by 0.1 m in all, the
# root of the sum of their squared distances.
left_out = people == np.unique(people)[-1]
pca = PoseTangentPCA(skeleton, n_components=0.9).fit(X[~left_out])
shares = ", ".join(f"{share:.0%}" for share in pca.explained_variance_ratio_)
print(f"{pca.n_components_} components explain 90 % of the variance: {shares}")

# %%
# Two standard deviations to each side of the mean, seen from the side: left limbs in blue, right ones in vermilion.
figure, axes = plt.subplots(3, 1, figsize=(9, 10), layout="constrained")
for component, ax in enumerate(axes):
    PoseDisplay.from_estimator(pca, component, projection="zy", ax=ax)
plt.show()

# %%
# Walks in the plane of the first two components are closed curves, once round for each cycle.
scores = pca.transform(X)
figure, ax = plt.subplots(figsize=(6, 5), layout="constrained")
for person in np.unique(people)[:4]:
    (first, *_) = np.unique(sequence[people == person])
    ax.plot(*scores[sequence == first, :2].T, ".-", label=str(person))
ax.set(xlabel="component 1 (m)", ylabel="component 2 (m)", aspect="equal")
ax.legend(title="person")
plt.show()

# %%
# The person who was left out, from so many components: PCA of the positions comes as near, and breaks bones.
F = forward_kinematics(X, skeleton)
flat = F.reshape(len(F), -1)
true = np.linalg.norm(skeleton.offsets, axis=1)
for k in (2, 5, 10):
    tangent = PoseTangentPCA(skeleton, n_components=k).fit(X[~left_out])
    error = np.sqrt(np.square(tangent.reconstruction_error(X[left_out])).mean())
    other = PCA(k).fit(flat[~left_out])
    joints = other.inverse_transform(other.transform(flat[left_out])).reshape(-1, *F.shape[1:])
    apart = np.sqrt(np.square(joints - F[left_out]).sum(axis=2).mean())
    near = np.concatenate([joints, np.zeros_like(joints[:, :1])], axis=1)[:, skeleton.parents]
    off = np.abs(np.linalg.norm(joints - near, axis=2) - true).max()
    print(
        f"{k:>2} components: joints {100 * error:.1f} cm off; by positions {100 * apart:.1f} cm, bones up to ", end=""
    )
    print(f"{100 * off:.1f} cm too long or short")
