"""Embeddings of poses in a few dimensions."""

from skpose.manifold._classical_mds import SpatialMDS

__all__ = ["SpatialMDS"]
