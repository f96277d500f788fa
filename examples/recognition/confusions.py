"""
What was taken for what
=======================

A share of motions that are recognised does not say which ones are not, nor why. `ConfusionDisplay` shows what was taken
for what, and for the most frequent confusions the motion itself, above the one that it resembles in the other class.

Whole recordings of generated gait are too easy to be confused. Here the task is made hard: pieces of half a second,
less than a stride, forward and backward in time, in which every angle of every frame is 4° off at random.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis
from sklearn.model_selection import LeaveOneGroupOut, cross_val_predict
from sklearn.pipeline import FeatureUnion, make_pipeline
from sklearn.preprocessing import StandardScaler

from skpose import MotionDistanceTransformer
from skpose.datasets import MotionDataset, make_gait
from skpose.plot import ConfusionDisplay

FRAME_RATE = 15  # Hz
NOISE = np.radians(4)

gait = make_gait(n_subjects=8, n_sequences=3, duration=2, frame_rate=FRAME_RATE, random_state=0).to_rotvec()
rng = np.random.default_rng(0)


def cut(motion, step):
    """Return a noisy piece of 0.5 to 0.7 s from anywhere in a motion; step -1 reverses its frames."""
    n = rng.integers(8, 11)
    start = rng.integers(len(motion) - n)
    piece = motion[start : start + n]
    return replace(piece, angles=piece.angles[::step] + NOISE * rng.normal(size=piece.angles.shape))


pieces = [cut(motion, step) for motion in gait for step in (1, -1)]
actions = [f"{action}{word}" for action in gait.actions for word in ("", " backward")]
dataset = MotionDataset(pieces, subjects=np.repeat(gait.subjects, 2), actions=actions)
print(dataset)

# %%
# The features of a motion are its distances to all training motions, of three kinds: between poses, between the
# velocities of the joints, and between poses less their mean over the motion. A linear model weighs them. One person
# after another is left out.
kinds = {metric: MotionDistanceTransformer(metric=metric, n_jobs=-1) for metric in ("position", "velocity", "centered")}
features = kinds | {"all three": FeatureUnion(list(kinds.items()))}
predicted = {}
for name, transformer in features.items():
    model = make_pipeline(transformer, StandardScaler(), LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto"))
    predicted[name] = cross_val_predict(
        model, dataset.motions, dataset.actions, groups=dataset.subjects, cv=LeaveOneGroupOut()
    )
    print(f"{name:<10}{np.mean(predicted[name] == dataset.actions):.1%} of the motions recognised")

# %%
# Rows of the matrix are the true classes. In each pair of strips the upper motion was taken for the class of the lower
# one, which is the nearest of that class among the other people.
display = ConfusionDisplay.from_predictions(dataset.actions, predicted["all three"], dataset, metric="position")
plt.show()

# %%
# The display keeps all confusions, in the order of their frequency. With a motion's index one can go on, for example
# with ``dataset[index].play()`` in a notebook.
for confusion in display.confusions[:3]:
    print(
        f"motion {confusion.sample}, {confusion.true}, was taken for {confusion.predicted}: "
        f"{confusion.distance:.2f} m from motion {confusion.nearest}"
    )
