"""Scores of predicted poses and motions, as plain functions that return a float, or an array with ``average=None``."""

from skpose.scores._acceleration import acceleration_error
from skpose.scores._angles import mean_angle_error
from skpose.scores._dtw import dtw_mje
from skpose.scores._geodesic import geodesic_error
from skpose.scores._mpjpe import mpjpe
from skpose.scores._npss import npss
from skpose.scores._pck import pck, pck_auc

__all__ = [
    "acceleration_error",
    "dtw_mje",
    "geodesic_error",
    "mean_angle_error",
    "mpjpe",
    "npss",
    "pck",
    "pck_auc",
]
