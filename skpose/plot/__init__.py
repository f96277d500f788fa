"""Pictures of poses and of distances between them, in the manner of scikit-learn's displays.

A display is made by one of its ``from_...`` methods, which draw it at once into the axes that are given, or into new
ones; it holds these as ``ax_`` and ``figure_``, and what it shows, to draw it again elsewhere with ``plot``. Nothing is
shown by itself. Needs matplotlib: ``pip install "skpose[plot]"``.
"""

from skpose.plot._distances import DistanceMatrixDisplay
from skpose.plot._geodesic import GeodesicDisplay
from skpose.plot._mds import MDSDisplay
from skpose.plot._pose import PoseDisplay, PoseStripDisplay

__all__ = ["DistanceMatrixDisplay", "GeodesicDisplay", "MDSDisplay", "PoseDisplay", "PoseStripDisplay"]
