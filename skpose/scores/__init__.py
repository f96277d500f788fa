"""Scores of predicted and generated motion: plain functions that return a float, or an array with ``average=None``."""

from skpose.scores._acceleration import acceleration_error
from skpose.scores._angles import mean_angle_error
from skpose.scores._dtw import dtw_mje
from skpose.scores._geodesic import geodesic_error
from skpose.scores._mpjpe import mpjpe
from skpose.scores._npss import npss
from skpose.scores._pck import pck, pck_auc
from skpose.scores._plausibility import foot_floating, foot_penetration, foot_skating, jerk

__all__ = [
    "acceleration_error",
    "dtw_mje",
    "foot_floating",
    "foot_penetration",
    "foot_skating",
    "geodesic_error",
    "jerk",
    "mean_angle_error",
    "mpjpe",
    "npss",
    "pck",
    "pck_auc",
]
