"""
Poses of a noisy pose estimator
===============================

A pose estimator gives positions of joints, with noise, gaps and confidences. The example generates such keypoints of
people who walk and run, finds the skeleton of each person and the poses on it, and classifies the poses by their
nearest neighbour. If SKPOSE_CMU names a folder of CMU files, the keypoints are of these people.
"""

# sphinx_gallery_tile = (1, 4)

import os

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation
from sklearn.model_selection import LeaveOneGroupOut, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import forward_kinematics, inverse_kinematics
from skpose.datasets import MotionDataset, load_cmu, make_gait, walks_and_runs
from skpose.keypoints import fit_skeleton, layouts
from skpose.plot import PoseDisplay
from skpose.preprocessing import PoseDistanceTransformer

RATE, NOISE = 25, 0.007  # Hz; m in each coordinate where the confidence is 1, and 1 cm in the mean
rng = np.random.default_rng(0)


def in_world(skeleton, poses, root_positions, root_rotations):
    """Positions of the joints in the world, (n_frames, n_joints, 3)."""
    return root_positions[:, None] + np.einsum(
        "nij,nkj->nki", root_rotations.as_matrix(), forward_kinematics(poses, skeleton)
    )


# %%
# A layout has the points and the bones between them. These people have the joints of COCO's arms and legs under other
# names; the layout adds pelvis and neck as midpoints of hips and shoulders.
layout = layouts["coco17"].without(["nose", "left_eye", "right_eye", "left_ear", "right_ear"])
points = "hip", "knee", "ankle", "shoulder", "elbow", "wrist"
folder = os.environ.get("SKPOSE_CMU")
if folder:
    people, left, right = walks_and_runs(load_cmu(folder)), "l", "r"
    bones = "hipjoint", "femur", "tibia", "clavicle", "humerus", "radius"
else:
    people, left, right = make_gait(n_subjects=4, n_sequences=2, duration=2.0, random_state=0), "left_", "right_"
    bones = "pelvis", "thigh", "shank", "clavicle", "upper_arm", "forearm"
joints = {f"left_{point}": left + bone for point, bone in zip(points, bones, strict=True)}
joints |= {f"right_{point}": right + bone for point, bone in zip(points, bones, strict=True)}
print(layout)


# %%
# The keypoints of a recording: noise is stronger for lower confidences, and each joint is lost twice for a sixth of a
# second.
def observe(motion):
    """True positions of a recording, and keypoints of a simulated pose estimator."""
    root = Rotation.from_euler(motion.root_axes, motion.root_angles)
    order = [motion.skeleton.joint_names.index(joints[name]) for name in layout.names]
    truth = in_world(motion.skeleton, motion.angles, motion.root_positions, root)[:, order]
    confidences = rng.uniform(0.2, 1.0, truth.shape[:2])
    positions = truth + NOISE / np.sqrt(confidences)[..., None] * rng.normal(size=truth.shape)
    for i in range(len(layout.names)):
        for start in rng.integers(0, len(motion), 2):
            positions[start : start + RATE // 6, i] = np.nan
    return truth, layout.keypoints(positions, frame_rate=RATE, confidences=confidences)


truths, seen = zip(*(observe(motion.resample(RATE)) for motion in people), strict=True)
print(seen[0])


# %%
# Fit one skeleton to all keypoints of each person, then poses to each recording, with `regularization` against noise.
def poses_of(recordings):
    """Poses of all recordings, each on the skeleton of its person."""
    fits = []
    for person, keypoints in zip(people.subjects, recordings, strict=True):
        own = [each for each, subject in zip(seen, people.subjects, strict=True) if subject == person]
        fits.append(inverse_kinematics(keypoints, fit_skeleton(own, layout), regularization=0.02))
    return fits


fits = {"poses": poses_of(seen), "gaps filled": poses_of([keypoints.fill_gaps() for keypoints in seen])}
print(fits["poses"][0])


# %%
# Errors of the keypoints, of the joints of the poses, and of joints that are not seen. A lost joint keeps its angles
# while people run on, so interpolated positions are better.
def fitted_positions(fit):
    """Positions of the joints of the layout, (n_frames, n_points, 3)."""
    world = in_world(fit.skeleton, fit.poses, fit.root_positions, Rotation.from_rotvec(fit.root_rotations))
    return world[:, [fit.skeleton.joint_names.index(name) for name in layout.names]]


given, truth = np.concatenate([keypoints.select(layout.names).positions for keypoints in seen]), np.concatenate(truths)
lost = np.isnan(given[..., 0])
print(f"{'keypoints':<12}{1e3 * np.linalg.norm(given - truth, axis=2)[~lost].mean():.1f} mm")
for name, of_all in fits.items():
    errors = 1e3 * np.linalg.norm(np.concatenate([fitted_positions(fit) for fit in of_all]) - truth, axis=2)
    print(f"{name:<12}{errors[~lost].mean():.1f} mm, joints not seen {errors[lost].mean():.1f} mm")

# %%
# Keypoints (dots) and fitted poses; circles are the true positions of joints that are not seen.
figure, axes = plt.subplots(1, 4, figsize=(10, 4.5), sharey=True, layout="constrained")
for ax, frame in zip(axes, np.linspace(5, len(seen[0]) - 6, 4).astype(int), strict=True):
    fit = fits["gaps filled"][0]
    root = fit.root_positions[frame]
    positions = in_world(fit.skeleton, fit.poses, fit.root_positions, Rotation.from_rotvec(fit.root_rotations))[frame]
    PoseDisplay.from_positions(positions - root, fit.skeleton, ax=ax, projection="zy")
    dots, circles = given[frame] - root, truths[0][frame][lost[frame]] - root
    ax.scatter(dots[:, 2], dots[:, 1], s=14, color="black", zorder=3)
    ax.scatter(circles[:, 2], circles[:, 1], s=50, facecolors="none", edgecolors="black", zorder=3)
    ax.set_title(f"{frame / RATE:.2f} s")
    ax.label_outer()
plt.show()

# %%
# The skeletons share the rest pose of the layout, so that equal numbers are equal poses. Hips and pelvis are on one
# line, so keypoints do not show the rotation about it; with the tilt of the root in the poses it has no effect.
motions = [fit.to_motion() for fit in fits["gaps filled"]]
dataset = MotionDataset(motions, subjects=people.subjects, actions=people.actions).with_root("tilt")
X, sequence = dataset.poses(frame_rate=12)
y, subject = dataset.actions[sequence], dataset.subjects[sequence]
for metric in ("position", "spatial"):
    distances = PoseDistanceTransformer(dataset.skeleton, metric=metric)
    classifier = make_pipeline(distances, KNeighborsClassifier(n_neighbors=1, metric="precomputed"))
    scores = cross_val_score(classifier, X, y, groups=subject, cv=LeaveOneGroupOut())
    print(f"{metric:<10}leave one person out: {scores.mean():.1%} of {len(X)} poses right")
