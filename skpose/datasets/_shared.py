"""Names of `skpose.datasets` that the other packages of skpose use, in addition to the public ones."""

from skpose.datasets._hdm05 import NAME
from skpose.datasets._index import INDEX, check_folder, read_index, rows_of
from skpose.datasets._motions import ONE_REST, ONE_RIG
from skpose.datasets._walks_and_runs import WALKING_AND_RUNNING

__all__ = [
    "INDEX",
    "NAME",
    "ONE_REST",
    "ONE_RIG",
    "WALKING_AND_RUNNING",
    "check_folder",
    "read_index",
    "rows_of",
]
