"""Plots of poses, of distances between them, of motions and of joint angles, as displays like those of scikit-learn.

A display is made by one of its ``from_...`` methods, which draw it into the given axes, or into new ones. It keeps
these as ``ax_`` and ``figure_``, and its data, so that ``plot`` can draw it again elsewhere. No window is opened.
Needs matplotlib: ``pip install "skpose[plot]"``.
"""

from skpose.plot._alignment import AlignmentDisplay
from skpose.plot._confused import Confusion
from skpose.plot._confusions import ConfusionDisplay
from skpose.plot._distances import DistanceMatrixDisplay
from skpose.plot._geodesic import GeodesicDisplay
from skpose.plot._joint_angles import JointAnglesDisplay
from skpose.plot._mds import MDSDisplay
from skpose.plot._mean_motion import MeanMotionDisplay
from skpose.plot._pose import PoseDisplay, PoseStripDisplay
from skpose.plot._tangent_pca import TangentPCADisplay

__all__ = [
    "AlignmentDisplay",
    "Confusion",
    "ConfusionDisplay",
    "DistanceMatrixDisplay",
    "GeodesicDisplay",
    "JointAnglesDisplay",
    "MDSDisplay",
    "MeanMotionDisplay",
    "PoseDisplay",
    "PoseStripDisplay",
    "TangentPCADisplay",
]
