"""Signatures of scores: "PA-MPJPE|mm|scale" says what to compute, or what was computed.

The parts, separated by "|", are the name, the unit, and options in any order: words such as "scale", "150mm", or pairs
"root=0" of a parameter and its value. What is not said is as by default.
"""

import re
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import Any, NamedTuple

from skpose._typing import ArrayLike
from skpose.metrics._scores._acceleration import PER_FRAME, PER_SECOND, acceleration_error
from skpose.metrics._scores._angles import ANGLES, mean_angle_error
from skpose.metrics._scores._dtw import dtw_mje
from skpose.metrics._scores._geodesic import geodesic_error
from skpose.metrics._scores._mpjpe import mpjpe
from skpose.metrics._scores._npss import npss
from skpose.metrics._scores._pck import UNITS, pck, pck_auc
from skpose.metrics._scores._points import LENGTHS
from skpose.metrics._scores._score import Score
from skpose.skeleton import Skeleton

Parse = Callable[[str], Any]


class Kind(NamedTuple):
    """A score that has a name."""

    function: Callable[..., Score]
    units: tuple[str, ...]  # the first is the default
    options: Mapping[str, Parse]  # parameters that a signature may set
    takes: str  # "positions", "rotations", "angles", or "series"
    is_sequence: bool = False  # whether frames are consecutive
    greater_is_better: bool = False
    aligns: bool = False  # whether "PA-" and "N-" may stand before the name


def _joints(text: str) -> Any:
    found = [int(one) if one.strip().isdigit() else one.strip() for one in text.split(",")]
    return found[0] if len(found) == 1 else found


def _flag(text: str) -> bool:
    if text not in ("True", "False"):
        raise ValueError
    return text == "True"


def _optional(text: str) -> str | None:
    return None if text == "None" else text


POSITIONS: dict[str, Parse] = {"root": _joints, "joints": _joints, "data_unit": str}
AVERAGED: dict[str, Parse] = POSITIONS | {"average": str}
KINDS = {
    "MPJPE": Kind(mpjpe, tuple(LENGTHS)[::-1], AVERAGED, "positions", aligns=True),
    "PCK": Kind(pck, tuple(UNITS), AVERAGED, "positions", greater_is_better=True, aligns=True),
    "PCK-AUC": Kind(
        pck_auc,
        tuple(UNITS),
        AVERAGED | {"n_thresholds": int, "rule": str},
        "positions",
        greater_is_better=True,
        aligns=True,
    ),
    "Accel": Kind(
        acceleration_error,
        tuple(f"{unit}{per}" for per in ("", PER_FRAME, PER_SECOND) for unit in tuple(LENGTHS)[::-1]),
        AVERAGED | {"frame_rate": float},
        "positions",
        is_sequence=True,
        aligns=True,
    ),
    "DTW-MJE": Kind(
        dtw_mje,
        tuple(LENGTHS)[::-1],
        POSITIONS | {"cost": str, "error": _optional, "divide": _optional, "warp": str, "pool": _flag},
        "positions",
        is_sequence=True,
        aligns=True,
    ),
    "Angle": Kind(
        mean_angle_error, tuple(ANGLES), {"wrap": _flag, "drop_constant": _optional, "data_unit": str}, "angles"
    ),
    "Geodesic": Kind(geodesic_error, tuple(ANGLES)[::-1], {"form": str, "frame": str, "average": str}, "rotations"),
    "NPSS": Kind(npss, ("",), {"spectrum": str}, "series", is_sequence=True),
}
PREFIXES = {"PA-": "similarity", "N-": "scale"}
DISTANCE = re.compile(r"(\d+(?:\.\d*)?(?:e-?\d+)?)\s*(mm|cm|m)")


class Call(NamedTuple):
    """A signature that was understood: the score, and the parameters of its function."""

    kind: Kind
    name: str
    parameters: dict[str, Any]


def parse_signature(signature: str) -> Call:
    """Return what a signature says."""
    if not isinstance(signature, str) or not signature.strip():
        raise ValueError(f"a signature must be a text such as 'PA-MPJPE|mm|scale', got {signature!r}")
    name, *parts = (part.strip() for part in signature.split("|"))
    kind, align, name = _kind_of(name)
    parameters: dict[str, Any] = {} if align is None else {"align": align}
    if parts and parts[0].replace("^", "").replace("2", "²") in kind.units and kind.units != ("",):
        parameters |= _unit(kind, parts.pop(0).replace("^", "").replace("2", "²"))
    said = set(parameters) - {"align"}  # a word may follow that of the name
    for part in parts:
        key, value = _option(part, kind, name, align)
        for one, setting in zip(key, value, strict=True):
            if one in said:
                raise ValueError(f"{signature!r} says {one} twice")
            said.add(one)
            parameters[one] = setting
    return _check_rate(Call(kind, name, parameters), signature)


def pose_score(
    signature: str,
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Score:
    """Return a score by its signature, "PA-MPJPE|mm|scale".

    Parameters
    ----------
    signature : str
        Name, unit and options, separated by "|". The names are "MPJPE", "PCK", "PCK-AUC", "Accel" and "DTW-MJE", each
        also with "PA-" before it for Procrustes alignment, or "N-" for scale, and "Angle", "Geodesic" and "NPSS".
        Options are parameters of their functions as "key=value", or words: "scale" or "rigid" after "PA-",
        "reflection", "inclusive", a threshold "150mm" of PCK, "each" or "norm" of angles. What is not said is as by
        default.
    y_true : array-like
        The truth, as the function takes it.
    y_pred : array-like
        The prediction, of the same shape.
    skeleton : Skeleton, default=None
        The skeleton, where truth and prediction are poses and the score is of positions or rotations.
    sample_weight : array-like, default=None
        Weights, as the function takes them.

    Returns
    -------
    Score
        The score. Its `signature` is the whole one, with which this function gives the same number.

    Raises
    ------
    ValueError
        For a signature that is not understood, with what was expected; as the function.

    See Also
    --------
    get_scorer : The same as a scorer for scikit-learn.
    mpjpe, pck, pck_auc, acceleration_error, dtw_mje : Scores of positions.
    mean_angle_error, geodesic_error, npss : Scores of angles, rotations and spectra.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.metrics import pose_score
    >>> true = np.random.default_rng(0).normal(scale=0.3, size=(100, 17, 3))  # m
    >>> pred = true + np.random.default_rng(1).normal(scale=0.02, size=true.shape)
    >>> for signature in ("MPJPE|mm", "PA-MPJPE|mm", "PA-MPJPE|mm|rigid", "PCK|%|50mm", "Accel|m/s²|frame_rate=30"):
    ...     score = pose_score(signature, true, pred)
    ...     print(f"{score.signature:32} {score:7.2f}")
    MPJPE|mm                           31.89
    PA-MPJPE|mm|scale                  29.39
    PA-MPJPE|mm|rigid                  29.85
    PCK|%|50mm                         90.41
    Accel|m/s²|frame_rate=30           70.35
    """
    call = parse_signature(signature)
    return compute(call, y_true, y_pred, skeleton, sample_weight)


def compute(call: Call, y_true: Any, y_pred: Any, skeleton: Skeleton | None, sample_weight: Any) -> Score:
    """Return the score of a signature that was understood."""
    parameters = dict(call.parameters)
    if skeleton is not None:
        if call.kind.takes not in ("positions", "rotations"):
            raise ValueError(f"{call.name} is of {call.kind.takes} as they are, and takes no skeleton=")
        parameters["skeleton"] = skeleton
    return call.kind.function(y_true, y_pred, sample_weight=sample_weight, **parameters)


def _kind_of(name: str) -> tuple[Kind, str | None, str]:
    """Return a score by its name, in any case, the alignment that the name says, and the name."""
    known = {one.lower(): one for one in KINDS}
    for prefix, align in PREFIXES.items():
        bare = name[len(prefix) :].lower()
        if name.lower().startswith(prefix.lower()) and bare in known and KINDS[known[bare]].aligns:
            return KINDS[known[bare]], align, prefix + known[bare]
    if name.lower() in known:
        return KINDS[known[name.lower()]], None, known[name.lower()]
    every = [*KINDS, *(f"{prefix}{one}" for one, kind in KINDS.items() if kind.aligns for prefix in PREFIXES)]
    near = get_close_matches(name.upper(), [one.upper() for one in every], 1)
    hint = f"; did you mean {next(one for one in every if one.upper() == near[0])!r}?" if near else ""
    raise ValueError(f"there is no score {name!r}{hint} The scores are {', '.join(KINDS)}, and PA- and N- before some")


def _unit(kind: Kind, unit: str) -> dict[str, Any]:
    return {"unit": unit.split("/")[0], **({"per": unit.split("/")[1]} if "/" in unit else {})}


def _option(part: str, kind: Kind, name: str, align: str | None) -> tuple[list[str], list[Any]]:
    """Return the parameters that a part of a signature sets, and their values."""
    key, equals, text = part.partition("=")
    if equals:
        if key in kind.options:
            try:
                return [key], [kind.options[key](text)]
            except ValueError:
                raise ValueError(f"{key}={text} of {name} must have a value that {key} takes") from None
        raise ValueError(f"{name} has no option {key!r}; its options are {', '.join(kind.options)}")
    distance = DISTANCE.fullmatch(part)
    if distance and kind.function in (pck, pck_auc):
        return ["threshold", "threshold_unit"], [float(distance[1]), distance[2]]
    if part == "inclusive" and kind.function in (pck, pck_auc):
        return ["inclusive"], [True]
    if part in ("scale", "rigid", "reflection") and align == "similarity":
        if part == "reflection":
            if kind.function is not dtw_mje:
                return ["reflection"], [True]
        else:
            return ["align"], ["similarity" if part == "scale" else "rigid"]
    if part in ("each", "norm") and kind.function is mean_angle_error:
        return ["kind"], [part]
    units = " or ".join(map(repr, kind.units)) if kind.units != ("",) else "none"
    raise ValueError(
        f"{part!r} is no unit and no option of {name}: its unit, {units}, is the second part, and options are "
        f"{', '.join(f'{key}=...' for key in kind.options)}"
        + (", 'scale' or 'rigid', 'reflection'" if align == "similarity" else "")
        + (", 'inclusive', a threshold such as '150mm'" if kind.function in (pck, pck_auc) else "")
        + (", 'each' or 'norm'" if kind.function is mean_angle_error else "")
    )


def _check_rate(call: Call, signature: str) -> Call:
    """Refuse an acceleration whose unit and frame rate contradict each other."""
    per = call.parameters.pop("per", None)
    has_rate = "frame_rate" in call.parameters
    if per == PER_SECOND[1:] and not has_rate:
        raise ValueError(f"{signature!r} is per second, which needs the frame rate: '|frame_rate=30'")
    if per == PER_FRAME[1:] and has_rate:
        raise ValueError(f"{signature!r} is per frame, and has a frame rate: with one the unit is 'mm/s²'")
    return call
