"""Names of `skpose.biomechanics` that the other packages of skpose use, in addition to the public ones."""

from skpose.biomechanics._recordings import are_of_one_recording, leg_lengths

__all__ = ["are_of_one_recording", "leg_lengths"]
