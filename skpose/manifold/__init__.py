"""Embeddings of poses in low dimensions."""

from skpose.manifold._classical_mds import SpatialMDS

__all__ = ["SpatialMDS"]
