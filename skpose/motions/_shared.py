"""What the other packages of skpose use of `skpose.motions` beside its public names."""

from skpose.motions._alignment import Quantity
from skpose.motions._inputs import Sequences, check_motions, rates_differ

__all__ = [
    "Quantity",
    "Sequences",
    "check_motions",
    "rates_differ",
]
