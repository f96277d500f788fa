"""
Exact neighbours for t-SNE and Isomap
=====================================

t-SNE and Isomap of scikit-learn accept a sparse graph of neighbours. `PoseKNeighborsTransformer` computes the exact
graph under the spatial distance, from a small part of all distances. If SKPOSE_CMU names a folder of CMU files, the
example runs on these.
"""

import os

import matplotlib.pyplot as plt
from sklearn.manifold import TSNE, Isomap

from skpose import PoseKNeighborsTransformer
from skpose.datasets import load_cmu, make_gait, walks_and_runs
from skpose.plot import MDSDisplay

folder = os.environ.get("SKPOSE_CMU")
dataset = walks_and_runs(load_cmu(folder) if folder else make_gait(random_state=0))
X, sequence = dataset.poses(frame_rate=6)
print(f"{dataset}: {len(X)} poses")

# %%
# One graph for both. t-SNE needs three times its perplexity, 30, and one more.
search = PoseKNeighborsTransformer(dataset.skeleton, n_neighbors=91, n_jobs=-1)
graph = search.fit_transform(X)
print(f"{graph.nnz} neighbours, of {len(X) ** 2} distances")

# %%
# The embeddings, coloured by action and by person.
embeddings = {
    "t-SNE": TSNE(metric="precomputed", init="random", random_state=0).fit_transform(graph),
    "Isomap": Isomap(n_neighbors=20, metric="precomputed").fit_transform(graph),
}
figure, axes = plt.subplots(2, 2, figsize=(11, 9), layout="constrained")
for row, (name, embedding) in zip(axes, embeddings.items(), strict=True):
    for ax, labels in zip(row, (dataset.actions[sequence], dataset.subjects[sequence]), strict=True):
        MDSDisplay.from_embedding(embedding, labels, unit="m" if name == "Isomap" else "no unit", ax=ax)
        ax.set_title(name)
plt.show()
