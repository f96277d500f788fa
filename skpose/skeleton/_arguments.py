"""Checks of single arguments that several functions share: a skeleton, its limits, a frame rate."""

from numbers import Real

import numpy as np

from skpose.skeleton._skeleton import Skeleton


def check_skeleton(skeleton: object) -> None:
    """Refuse what is no skeleton, with the skeleton to pass instead where there is one."""
    if not isinstance(skeleton, Skeleton):
        raise TypeError(f"skeleton must be a skpose.Skeleton, got {type(skeleton).__name__}{_remedy(skeleton)}")


def explain_no_skeleton(value: object) -> None:
    """Refuse a value in the place of a skeleton if there is a remedy: the check of scikit-learn has none."""
    if _remedy(value):
        check_skeleton(value)


def _remedy(value: object) -> str:
    if value is None or isinstance(value, Skeleton):
        return ""
    if "skeleton" in dir(value):  # a motion, a dataset, an ASF file
        name = type(value).__name__
        return f": pass its skeleton, {'dataset' if name == 'MotionDataset' else name.lower()}.skeleton"
    if isinstance(value, str):
        return ": skpose.io.load_motion(path).skeleton reads one from a file"
    if hasattr(value, "__array__") or isinstance(value, list | tuple):
        return ": poses come first, then the skeleton"
    return ""


def limits_of(skeleton: Skeleton) -> np.ndarray:
    """Return the limits (n_dofs, 2) that are to be enforced, or refuse a skeleton without any."""
    if skeleton.limits is None:
        raise ValueError(
            'joint_limits="enforce" needs a skeleton with limits, and none of its bones has any: give limits to its '
            'bones, or use joint_limits="ignore"'
        )
    return skeleton.limits


def check_frame_rate(frame_rate: object) -> float:
    """Return a rate as a number, or refuse it."""
    number = isinstance(frame_rate, Real) or (
        isinstance(frame_rate, np.ndarray) and frame_rate.ndim == 0 and frame_rate.dtype.kind in "iuf"
    )
    rate = float(frame_rate) if number else np.nan  # type: ignore[arg-type]
    if not np.isfinite(rate) or rate <= 0 or isinstance(frame_rate, bool):
        raise ValueError(f"frame_rate must be a positive number of Hz, got {frame_rate!r}")
    return rate
