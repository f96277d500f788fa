"""Datasets of motions: folders of files, generated gait and actions, the databases CMU and HDM05."""

from skpose.datasets._cmu import fetch_cmu, load_cmu, load_hdm05
from skpose.datasets._folder import load_motions
from skpose.datasets._gait import humanoid, make_actions, make_gait, walks_and_runs as walks_and_runs
from skpose.datasets._motions import MotionDataset

__all__ = [
    "MotionDataset",
    "fetch_cmu",
    "humanoid",
    "load_cmu",
    "load_hdm05",
    "load_motions",
    "make_actions",
    "make_gait",
]
