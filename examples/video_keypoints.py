"""
From video keypoints to distances
=================================

A pose estimator gives positions of joints, with noise, gaps and confidences. The example generates such keypoints of
people who walk and run, finds the skeleton of each person and the poses on it, and classifies the poses by their nearest
neighbour. If SKPOSE_CMU names a folder of CMU files, the keypoints are of these people.
"""

import os
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation
from sklearn.model_selection import LeaveOneGroupOut, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import Keypoints, PoseDistanceTransformer, fit_skeleton, forward_kinematics, inverse_kinematics
from skpose.datasets import MotionDataset, load_cmu, make_gait, walks_and_runs
from skpose.keypoints import layouts
from skpose.plot import PoseDisplay

RATE, NOISE = 25, 0.007  # Hz; m in each coordinate where the confidence is 1, and 1 cm in the mean
rng = np.random.default_rng(0)


def in_world(skeleton, poses, root_positions, root_rotations):
    """Return where the joints are, (n_frames, n_joints, 3)."""
    return root_positions[:, None] + np.einsum(
        "nij,nkj->nki", root_rotations.as_matrix(), forward_kinematics(poses, skeleton)
    )


# %%
# A layout states which points there are, and how bones join them. The generated people have joints for the 17 points of
# Human3.6M, though with y up; those of CMU for its own layout.
folder = os.environ.get("SKPOSE_CMU")
if folder:
    people = walks_and_runs(load_cmu(folder))
    parts = "hand", "fingers", "thumb", "toes"  # bones of a few centimetres
    layout = layouts["cmu31"].without([f"{side}{part}" for side in "lr" for part in parts])
    joints = {name: name for name in layout.names}
else:
    people = make_gait(n_subjects=4, n_sequences=2, duration=2.0, random_state=0)
    layout = replace(layouts["h36m17"], up="y")
    joints = {"spine": "abdomen", "thorax": "chest", "neck": "neck", "head": "head"}
    ends = {"hip": "pelvis", "knee": "thigh", "ankle": "shank"}
    ends |= {"shoulder": "clavicle", "elbow": "upper_arm", "wrist": "forearm"}
    joints |= {f"{side}_{name}": f"{side}_{bone}" for side in ("left", "right") for name, bone in ends.items()}
print(layout)


# %%
# The keypoints of a recording: noise that is stronger where the confidence is lower, and joints that are lost, two
# times each for a sixth of a second.
def observe(motion):
    """Return the true positions of a recording, and keypoints as a pose estimator gives them."""
    root = Rotation.from_euler(motion.root_axes, motion.root_angles)
    world = in_world(motion.skeleton, motion.angles, motion.root_positions, root)
    truth = np.repeat(motion.root_positions[:, None], len(layout.names), axis=1)
    for i, name in enumerate(layout.names):
        if name != layout.root:
            truth[:, i] = world[:, motion.skeleton.joint_names.index(joints[name])]
    confidences = rng.uniform(0.2, 1.0, truth.shape[:2])
    positions = truth + NOISE / np.sqrt(confidences)[..., None] * rng.normal(size=truth.shape)
    for i in range(len(layout.names)):
        for start in rng.integers(0, len(motion), 2):
            positions[start : start + RATE // 6, i] = np.nan
    return truth, layout.keypoints(positions, frame_rate=RATE, confidences=confidences)


truths, seen = zip(*(observe(motion.resample(RATE)) for motion in people), strict=True)
print(seen[0])

# %%
# Each person has a skeleton, whose bones have the lengths that all their keypoints show together. Then each recording
# gives poses on it. Noise of a centimetre needs a little stiffness, `regularization`: hips and pelvis are on one line,
# and what turns the pelvis about it is better seen in the trunk and the thighs at once.
motions, fits = [], []
for person, keypoints in zip(people.subjects, seen, strict=True):
    own = [each for each, subject in zip(seen, people.subjects, strict=True) if subject == person]
    positions, confidences = (np.concatenate([getattr(each, name) for each in own]) for name in ("positions", "confidences"))
    together = Keypoints(positions, keypoints.names, RATE, confidences, up=keypoints.up)
    fits.append(inverse_kinematics(keypoints, fit_skeleton(together, layout), regularization=0.02))
    motions.append(fits[-1].to_motion(RATE, up=keypoints.up))
print(fits[0])

# %%
# What this is worth: the distance from the truth of the keypoints, of the fitted joints, and of those not seen.
fitted, names = [], list(layout.names)
for fit in fits:
    order = [fit.skeleton.joint_names.index(name) for name in names]
    world = in_world(fit.skeleton, fit.poses, fit.root_positions, Rotation.from_rotvec(fit.root_rotations))
    fitted.append(world[:, order])
given = np.concatenate([keypoints.select(names).positions for keypoints in seen])
truth, found = np.concatenate(truths), np.concatenate(fitted)
lost = np.isnan(given[..., 0])
for name, positions, which in (("keypoints", given, ~lost), ("poses", found, ~lost), ("poses, joints not seen", found, lost)):
    print(f"{name:<24}{1e3 * np.linalg.norm(positions - truth, axis=2)[which].mean():.1f} mm from the truth")

# %%
# Keypoints (dots) and fitted poses; circles are where the joints that are not seen really are.
figure, axes = plt.subplots(1, 4, figsize=(10, 4.5), sharey=True, layout="constrained")
for ax, frame in zip(axes, np.linspace(5, len(seen[0]) - 6, 4).astype(int), strict=True):
    fit, root = fits[0], fits[0].root_positions[frame]
    positions = in_world(fit.skeleton, fit.poses, fit.root_positions, Rotation.from_rotvec(fit.root_rotations))[frame]
    PoseDisplay.from_positions(positions - root, fit.skeleton, ax=ax, view="zy")
    dots, circles = given[frame] - root, truths[0][frame][lost[frame]] - root
    ax.scatter(dots[:, 2], dots[:, 1], s=14, color="black", zorder=3)
    ax.scatter(circles[:, 2], circles[:, 1], s=50, facecolors="none", edgecolors="black", zorder=3)
    ax.set_title(f"{frame / RATE:.2f} s")
    ax.label_outer()
plt.show()

# %%
# The skeletons differ in their rest poses, so that equal numbers are not equal poses: orientations bring all motions onto
# one skeleton. From there on keypoints are poses like any others.
dataset = MotionDataset(motions, subjects=people.subjects, actions=people.actions)
dataset = dataset.retarget(motions[0].skeleton, method="orientations").with_root("tilt")
X, sequence = dataset.poses(frame_rate=12)
y, subject = dataset.actions[sequence], dataset.subjects[sequence]
for metric in ("position", "spatial"):
    distances = PoseDistanceTransformer(dataset.skeleton, metric=metric)
    classifier = make_pipeline(distances, KNeighborsClassifier(n_neighbors=1, metric="precomputed"))
    scores = cross_val_score(classifier, X, y, groups=subject, cv=LeaveOneGroupOut())
    print(f"{metric:<10}leave one person out: {scores.mean():.1%} of {len(X)} poses right")
