"""Statistics of poses: their principal components, regression with poses as targets, tests of two sets."""

from skpose.statistics._tangent_pca import PoseTangentPCA

__all__ = ["PoseTangentPCA"]
