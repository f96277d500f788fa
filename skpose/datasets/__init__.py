"""Collections of motions: generated gait, and the CMU motion-capture database."""

from skpose.datasets._cmu import fetch_cmu, load_cmu
from skpose.datasets._gait import humanoid, make_gait
from skpose.datasets._motions import MotionDataset, walks_and_runs

__all__ = ["MotionDataset", "fetch_cmu", "humanoid", "load_cmu", "make_gait", "walks_and_runs"]
