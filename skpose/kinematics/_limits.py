"""A check that a retargeted motion stays within the limits of its skeleton."""

import numpy as np

from skpose._validation.skeletons import limits_of
from skpose.skeleton import Motion
from skpose.skeleton._shared import are_slides


def check_within_limits(motion: Motion, method: str) -> None:
    """Refuse a motion that leaves the limits of its skeleton."""
    limits = limits_of(motion.skeleton)
    beyond = np.maximum(limits[:, 0] - motion.angles, motion.angles - limits[:, 1])
    if beyond.size and beyond.max() > 0.0:
        frame, dof = np.unravel_index(beyond.argmax(), beyond.shape)
        most = float(beyond.max())
        is_slide = are_slides(motion.skeleton.bones)[dof]
        raise ValueError(
            f'by method="{method}" {int((beyond > 0.0).any(axis=0).sum())} angles leave the limits of the skeleton, '
            f"most {motion.skeleton.dof_names[dof]!r} by "
            f"{f'{most:.3g} m' if is_slide else f'{np.degrees(most):.3g}°'} in frame {frame}: "
            'method="limbs" and "positions" find poses within limits'
        )
