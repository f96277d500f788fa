"""Names of `skpose.neighbors` that the other packages of skpose use, in addition to the public ones."""

from skpose.neighbors._filter import FLOAT32, ChordFilter, FilterPoints
from skpose.neighbors._graph import check_mode, checked_k, sparse_graph
from skpose.neighbors._index import PoseIndex
from skpose.neighbors._results import requested

__all__ = [
    "FLOAT32",
    "ChordFilter",
    "FilterPoints",
    "PoseIndex",
    "check_mode",
    "checked_k",
    "requested",
    "sparse_graph",
]
