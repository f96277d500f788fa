"""Series of numbers of frames that the user gives: angles, or features of which spectra are taken."""

from typing import Any, NamedTuple

import numpy as np

from skpose._validation.numbers import as_numbers
from skpose.metrics._scores._points import check_finite, check_predictions, is_list_of_motions, read_weights


class Series(NamedTuple):
    """Motions of the truth and of the prediction, with the weight of each frame."""

    true: list[np.ndarray]  # (n_frames, n_columns) each, NaN where it is not known
    pred: list[np.ndarray]
    weights: list[np.ndarray]  # (n_frames,) each


def read_series(y_true: Any, y_pred: Any, sample_weight: Any, what: str, is_vector_known: bool = True) -> Series:
    """Return the motions of truth and prediction, checked; `what` the columns are.

    A vector is one column, as a regressor of one number predicts it, or is refused, where one frame would be another
    number.
    """
    true, several = _split(y_true, "y_true", what, is_vector_known)
    pred, _ = _split(y_pred, "y_pred", what, is_vector_known)
    shapes, other = [one.shape for one in true], [one.shape for one in pred]
    if shapes != other:
        raise ValueError(
            f"y_true and y_pred must have equal shapes, frame by frame and column by column, got {_shapes(shapes)} and "
            f"{_shapes(other)}"
        )
    if not shapes or not all(all(shape) for shape in shapes):
        raise ValueError(f"y_true must have frames and {what}, got {_shapes(shapes)}")
    if len({shape[1] for shape in shapes}) > 1:
        raise ValueError(f"all motions must have the same {what}, got {_shapes(shapes)}")
    for i, (one, another) in enumerate(zip(true, pred, strict=True)):
        check_finite(one, f"y_true[{i}]" if several else "y_true")
        check_predictions(another, f"y_pred[{i}]" if several else "y_pred")
    lengths = [len(one) for one in true]
    weights = np.split(read_weights(sample_weight, lengths, several), np.cumsum(lengths)[:-1])
    return Series(true, pred, weights)


def _split(values: Any, name: str, what: str, is_vector_known: bool) -> tuple[list[np.ndarray], bool]:
    """Return the motions, (n_frames, n_columns), and whether several could be given."""
    if is_list_of_motions(values):
        arrays = [as_numbers(one, f"{name}[{i}]") for i, one in enumerate(values)]
    else:
        array = as_numbers(values, name)
        if array.ndim == 1 and not is_vector_known:
            raise ValueError(
                f"{name} has shape {array.shape}, which does not say what a frame is: pass np.reshape({name}, (1, -1)) "
                f"for one frame of {len(array)} {what}, np.reshape({name}, (-1, 1)) for {len(array)} frames of one"
            )
        if array.ndim in (1, 2):  # a regressor of one number predicts a vector
            return [array.reshape(len(array), -1)], False
        arrays = list(array) if array.ndim > 2 else [array]
    if any(one.ndim not in (2, 3) for one in arrays):
        raise ValueError(
            f"{name} must have shape (n_frames, n_{what}), (n_motions, n_frames, n_{what}), or be a list of motions, "
            f"got {_shapes([one.shape for one in arrays])}"
        )
    if not is_list_of_motions(values) and arrays and arrays[0].shape[1:] == (3,):
        shape = (len(arrays), *arrays[0].shape)
        raise ValueError(
            f"{name} has shape {shape}: {shape[0]} motions of {shape[1]} frames and three {what}, or {shape[0]} frames "
            f"of {shape[1]} joints? Pass list({name}) for motions, {name}.reshape(len({name}), -1) for frames"
        )
    return [one.reshape(len(one), -1) for one in arrays], True


def _shapes(shapes: list[tuple[int, ...]]) -> str:
    return ", ".join(map(str, dict.fromkeys(shapes))) or "none"
