"""What the other packages of skpose use of `skpose.keypoints` beside its public names."""

from skpose.keypoints._keypoints import as_numbers, check_positions

__all__ = [
    "as_numbers",
    "check_positions",
]
