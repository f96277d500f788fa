"""
Choose the metric by grid search
================================

The metric is a parameter like any other. The best one depends on the new data: recordings of people who are in the
training data, or of new people. If SKPOSE_CMU names a folder of CMU files, the example runs on these.
"""

import os

import matplotlib.pyplot as plt
import numpy as np
from sklearn.model_selection import GridSearchCV, GroupKFold, LeaveOneGroupOut
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import Pipeline

from skpose import PoseDistanceTransformer
from skpose.datasets import load_cmu, make_gait, walks_and_runs

folder = os.environ.get("SKPOSE_CMU")
dataset = walks_and_runs(load_cmu(folder) if folder else make_gait(random_state=0))
X, sequence = dataset.poses(frame_rate=6)
y, subject = dataset.actions[sequence], dataset.subjects[sequence]
print(f"{dataset}: {len(X)} poses")

# %%
# Frames of one recording are nearly the same pose, so the folds keep groups whole: recordings in the first search,
# people in the second.
pipeline = Pipeline(
    [
        ("distances", PoseDistanceTransformer(dataset.skeleton)),
        ("classifier", KNeighborsClassifier(metric="precomputed")),
    ]
)
metrics, numbers = ["angle", "position", "rotation", "spatial"], [1, 5, 15]
grid = {"distances__metric": metrics, "classifier__n_neighbors": numbers}
searches = {
    "new recordings": GridSearchCV(pipeline, grid, cv=GroupKFold(5)).fit(X, y, groups=sequence),
    "new people": GridSearchCV(pipeline, grid, cv=LeaveOneGroupOut()).fit(X, y, groups=subject),
}
for name, search in searches.items():
    print(
        f"{name}: best {search.best_params_['distances__metric']}, k = "
        f"{search.best_params_['classifier__n_neighbors']}, {search.best_score_:.1%} right"
    )

# %%
# All scores, the share of poses classified right. Lines would hide each other where all are right.
tables = {}
for name, search in searches.items():
    results = search.cv_results_
    order = [
        (results["param_distances__metric"] == metric) & (results["param_classifier__n_neighbors"] == number)
        for metric in metrics
        for number in numbers
    ]
    scores = [100 * results["mean_test_score"][chosen].item() for chosen in order]
    tables[name] = np.reshape(scores, (len(metrics), len(numbers)))
figure, axes = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True, layout="constrained")
for ax, (name, table) in zip(axes, tables.items(), strict=True):
    ax.imshow(table, vmin=80, vmax=160, cmap="Blues", aspect="auto")
    for (row, column), score in np.ndenumerate(table):
        ax.text(column, row, f"{score:.1f} %", ha="center", va="center", size=13)
    ax.set_xticks(range(len(numbers)), numbers)
    ax.set_yticks(range(len(metrics)), metrics, size=12)
    ax.set(xlabel="neighbours", title=name)
plt.show()
