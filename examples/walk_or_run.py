"""
Walking or running?
===================

From motions to a cross-validated classifier: read them, put all poses on one skeleton, and let the nearest neighbour
decide, once for each metric, on people that it has not seen. With SKPOSE_CMU naming a folder of CMU files, on these.
"""

import os

from sklearn.model_selection import GridSearchCV, GroupKFold, LeaveOneGroupOut, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import PoseDistanceTransformer
from skpose.compare import walks_and_runs
from skpose.datasets import load_cmu, make_gait

folder = os.environ.get("SKPOSE_CMU")
dataset = walks_and_runs(load_cmu(folder) if folder else make_gait(random_state=0))
print(dataset)

# %%
# Poses at the paper's 12 Hz, on the mean skeleton of all subjects; what they do, and who they are.
X, sequence = dataset.poses(frame_rate=12)
y, subject = dataset.actions[sequence], dataset.subjects[sequence]

# %%
# The distances to the training poses are a step of a pipeline like any other.
distances = PoseDistanceTransformer(dataset.skeleton, metric="spatial")
classifier = make_pipeline(distances, KNeighborsClassifier(n_neighbors=1, metric="precomputed"))
scores = cross_val_score(classifier, X, y, groups=subject, cv=LeaveOneGroupOut())
print(f"leave one subject out, spatial: {scores.mean():.1%} (worst subject {scores.min():.1%})")

# %%
# Which metric is best? Sequences stay whole, as neighbouring frames are nearly the same pose.
grid = {"posedistancetransformer__metric": ["angle", "position", "rotation", "spatial"]}
search = GridSearchCV(classifier, grid, cv=GroupKFold(5)).fit(X, y, groups=sequence)
for parameters, score in zip(search.cv_results_["params"], search.cv_results_["mean_test_score"], strict=True):
    print(f"{score:.1%}", *parameters.values())
