"""Plots of poses, distances, motions and joint angles, as displays in the manner of scikit-learn.

A display is made by one of its ``from_...`` methods, which draw it into the given axes, or into new ones. It keeps
these as ``ax_`` and ``figure_``, and its data, so that ``plot`` can draw it again elsewhere. No window is opened.
Needs matplotlib: ``pip install "skpose[plot]"``.
"""

from skpose.plot._alignment import AlignmentDisplay
from skpose.plot._distances import DistanceMatrixDisplay
from skpose.plot._geodesic import GeodesicDisplay
from skpose.plot._joint_angles import JointAnglesDisplay
from skpose.plot._mds import MDSDisplay
from skpose.plot._pose import PoseDisplay

__all__ = [
    "AlignmentDisplay",
    "DistanceMatrixDisplay",
    "GeodesicDisplay",
    "JointAnglesDisplay",
    "MDSDisplay",
    "PoseDisplay",
]
