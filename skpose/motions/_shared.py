"""Names of `skpose.motions` that the other packages of skpose use, in addition to the public ones."""

from skpose.motions._alignment import Quantity
from skpose.motions._inputs import CheckedMotions, Sequences, check_motions, rates_differ

__all__ = [
    "CheckedMotions",
    "Quantity",
    "Sequences",
    "check_motions",
    "rates_differ",
]
