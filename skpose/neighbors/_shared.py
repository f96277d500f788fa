"""Names of `skpose.neighbors` that the other packages of skpose use, in addition to the public ones."""

from skpose.neighbors._filter import FLOAT32, ChordFilter, FilterPoints
from skpose.neighbors._graph import check_k, check_mode, sparse_graph
from skpose.neighbors._index import PoseIndex
from skpose.neighbors._results import select_requested

__all__ = [
    "FLOAT32",
    "ChordFilter",
    "FilterPoints",
    "PoseIndex",
    "check_k",
    "check_mode",
    "select_requested",
    "sparse_graph",
]
