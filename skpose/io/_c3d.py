"""C3D files, positions of markers as most motion-capture systems write them, and quantities that models compute."""

import re
from typing import Any, NamedTuple

import numpy as np

from skpose._utils.units import complaint_of_extent
from skpose.io._arguments import Readable
from skpose.io._c3d_file import MIPS, Parameters, read_recording
from skpose.io._conventions import Up, Zeros, check_options, number_names, read_unit, stand_markers
from skpose.io._error import MocapFormatError
from skpose.io._source import Source, open_source
from skpose.keypoints import Keypoints
from skpose.keypoints._checks import UPS

# The parameters of the group POINT that list labels of points that are not positions. POINT:TYPE_GROUPS names more of
# them, each with the singular of its name, by which its unit is found.
KINDS = "ANGLES", "SYMBOLIC_ANGLES", "FORCES", "MOMENTS", "POWERS", "REACTIONS", "SCALARS"
# Parts of the names of groups that list positions.
OF_MARKERS = "MARKER", "TRAJECTOR", "POINT", "LABEL", "DESCRIPTION"
# Words at the end of labels that are not positions by their names alone, before a number, a side or an axis. Points of
# the body and of things are: the inferior angle of the scapula, a marker of a triangle.
BY_NAME = {
    "angle": "ANGLES", "force": "FORCES", "grf": "FORCES", "moment": "MOMENTS", "torque": "MOMENTS", "power": "POWERS",
}  # fmt: skip
QUANTITY = re.compile(rf"({'|'.join(BY_NAME)})s?(?:[\s_.-]*\d+|[\s_.-]+(?:left|right|[lrxyz]))*\Z")
ANATOMICAL = re.compile(r"(?:tri|rect|quadr|(?:inf|sup|scap|acrom|stern|mandib|jaw|cost|rib)[a-z]*[\s_.-]*)angle")

Groups = dict[str, list[tuple[str, str]]]  # by a label without its prefix, the kind ("" for positions) and the prefix


class C3DQuantity(NamedTuple):
    """A quantity that a model has computed from markers in each frame, such as the angles of a joint, or an event."""

    kind: str  # "angles", "forces", "moments", "powers", "reactions", "scalars", "events" or another group of the file
    unit: str  # such as "deg", "N" or "Nmm"; empty if the file names none
    values: np.ndarray  # (n_frames, 3), as in the file, NaN where there are none; of events (n_events,), times, s


def load_c3d(
    path: Readable,
    *,
    up: Up | None = None,
    scale: float | None = None,
    frame_rate: float | None = None,
    zeros: Zeros | None = None,
) -> Keypoints:
    """Read positions of markers from a C3D file.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The axis that points up. By default the file's POINT:Y_SCREEN, or z, with a warning; or, with a warning, another
        axis if the points that stand still while others move are in one plane below these, as feet on a floor. If an
        axis points down, the world is turned by half a turn: about x for y and z, about y for x.
    scale : float, default=None
        Metres per unit of length. By default that of POINT:UNITS.
    frame_rate : float, default=None
        Frames per second, Hz. By default POINT:RATE; a number replaces it, with a warning if the two differ by more
        than 1 %.
    zeros : {"seen", "missing"}, default=None
        Whether a position of exactly (0, 0, 0) is a position or a lost marker. By default a position, with a warning.

    Returns
    -------
    Keypoints
        Positions in m, NaN where a marker is lost.

    Raises
    ------
    MocapFormatError
        If the file is damaged, cut short, or holds no positions; with its name and the parameter.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If points are left out or numbered, positions are (0, 0, 0), all residuals are negative, the up axis is unknown
        or unlikely, header and parameters differ, or the markers are not of the size of a person.

    See Also
    --------
    load_c3d_quantities : Read angles, forces, moments, powers and scalars of a model.
    load_trc : Read a TRC file.
    skpose.inverse_kinematics : The poses of a skeleton at these positions.

    Notes
    -----
    The labels that POINT:ANGLES, FORCES, MOMENTS, POWERS, REACTIONS, SCALARS and other groups of POINT:TYPE_GROUPS list
    are not positions, in any case of the letters, with or without the prefix of a subject (``Anna:LKneeAngles``). Nor
    are labels that no group lists and that end in Angle, Force, GRF, Moment, Torque or Power.

    A marker is lost where its residual is negative. Numbers may be floats or scaled integers, of Intel, DEC or MIPS.
    Analog channels, force plates and rotations are not read.

    References
    ----------
    .. [1] Motion Lab Systems, "The C3D file format user guide", https://www.c3d.org/HTML/default.htm.

    Examples
    --------
    >>> from skpose.io import load_c3d
    >>> load_c3d("walk.c3d")  # doctest: +SKIP
    Keypoints(580 frames at 100 Hz, 5.8 s, 51 points, 0.8 % not seen)
    """
    check_options(up=up, zeros=zeros, scale=scale, frame_rate=frame_rate)
    source = open_source(path, "a C3D file", binary=True)
    with source.format_errors():
        parameters, rate, all_positions, names, kinds = _read(source, frame_rate)
        chosen = [i for i in names if i not in kinds]
        if kinds:
            message = f"{len(kinds)} of {len(names)} points are not positions of markers, such as {names[min(kinds)]!r}"
            if not chosen:
                raise source.error(f"{message}: load_c3d_quantities reads them")
            source.warn(f"{message} and are left out; load_c3d_quantities reads them by their names")
        labels = [names[i] for i in chosen]
        units = parameters.texts("POINT:UNITS") if scale is None else _texts_if_any(parameters, "POINT:UNITS")
        scale = read_unit(source, "POINT:UNITS", units[0] if units else "", scale)
        usual = _up(source, parameters) if up is None else (up, "")
        positions, axis = stand_markers(source, all_positions[:, chosen], labels, scale, zeros, up, usual)
        found = Keypoints(positions, labels, rate, up=axis)
        source.warn(complaint_of_extent(found.positions, scale))
        return found


def load_c3d_quantities(path: Readable) -> dict[str, C3DQuantity]:
    """Read angles, forces, moments, powers and scalars, which models such as Plug-in Gait write, and events.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.

    Returns
    -------
    dict of str to C3DQuantity
        By label, in the order of the file: `kind`, such as "angles" or "moments", `unit`, such as "deg", and `values`,
        (n_frames, 3), of the points that are not positions, see the notes of `load_c3d`. Events, such as "Left Foot
        Strike", follow with the kind "events" and times (n_events,) since the first frame, s; `gait_events` takes them.

    Raises
    ------
    MocapFormatError
        If the file is damaged or cut short; with its name and the parameter.
    OSError
        If it cannot be read.

    See Also
    --------
    load_c3d : Read the positions of the markers.

    Notes
    -----
    Axes, signs and order of angles are those of the model that computed them; the file does not state them.

    Examples
    --------
    >>> from skpose.io import load_c3d_quantities
    >>> quantities = load_c3d_quantities("walk.c3d")  # doctest: +SKIP
    >>> quantities["LKneeAngles"].unit, quantities["LKneeAngles"].values.shape  # doctest: +SKIP
    ('deg', (580, 3))
    """
    source = open_source(path, "a C3D file", binary=True)
    with source.format_errors():
        parameters, rate, positions, names, kinds = _read(source, None)
        found = dict[str, C3DQuantity]()
        for i, kind in kinds.items():
            units = parameters.texts(f"POINT:{kind.removesuffix('S')}_UNITS")
            found[names[i]] = C3DQuantity(kind.lower(), next(iter(units), ""), positions[:, i])
        first = int.from_bytes(source.data[6:8], "big" if parameters.processor == MIPS else "little")
        times = parameters.numbers("EVENT:TIMES").reshape(-1, 2) @ [60.0, 1.0] - (first - 1) / rate  # min and s
        words = (_texts_if_any(parameters, name) for name in ("EVENT:CONTEXTS", "EVENT:LABELS"))
        events = [(f"{context} {label}".strip(), time) for time, context, label in zip(times, *words, strict=False)]
        for name in dict.fromkeys(name for name, _ in events):
            found[name] = C3DQuantity("events", "s", np.array([time for other, time in events if other == name]))
        return found


def _read(
    source: Source, frame_rate: float | None
) -> tuple[Parameters, float, np.ndarray, dict[int, str], dict[int, str]]:
    """A recording, and by the indices of its points the names, where they have one, and the kinds of quantities."""
    if source.kind != "C3D":
        raise source.error("expected a C3D file, whose second byte is 80")
    parameters, rate, positions = read_recording(source, frame_rate)
    n_points = positions.shape[1]
    labels = parameters.texts("POINT:LABELS")[:n_points]
    named = [i for i, label in enumerate(labels) if label]
    if not named:
        source.warn(f"none of its {n_points} points has a name (POINT:LABELS): they are called by their numbers")
        return parameters, rate, positions, {i: str(i + 1) for i in range(n_points)}, {}
    if without := n_points - len(named):
        source.warn(f"{without} of {n_points} points have no label and are left out")
    names = number_names(source, [labels[i] for i in named])
    groups = _list_groups(parameters)
    kinds = {i: kind for i in named if (kind := _kind_of(labels[i], groups))}
    return parameters, rate, positions, dict(zip(named, names, strict=True)), kinds


def _list_groups(parameters: Parameters) -> Groups:
    more = [group.upper() for group in _texts_if_any(parameters, "POINT:TYPE_GROUPS")]
    found: Groups = {}
    for group in dict.fromkeys([*KINDS, "MODELED_MARKERS", "VIRTUAL_MARKERS", *more]):
        kind, name = "" if any(part in group for part in OF_MARKERS) else group, f"POINT:{group}"
        for label in parameters.texts(name) if group in KINDS else _texts_if_any(parameters, name):
            if label:
                prefix, rest = _split(label)
                found.setdefault(rest, []).append((kind, prefix))
    return found


def _texts_if_any(parameters: Parameters, name: str) -> list[str]:
    """The texts of a parameter that points do not need: none if it is damaged."""
    try:
        return parameters.texts(name)
    except MocapFormatError:
        return []


def _split(label: str) -> tuple[str, str]:
    """The prefix of a label, as that of a subject before a colon, and the rest, in lower case."""
    prefix, _, name = label.lower().rpartition(":")
    return prefix.strip(), name.strip()


def _kind_of(label: str, groups: Groups) -> str:
    """The kind of quantity of a label, empty for a marker.

    Labels are the same in any case of the letters, and where one of them has no prefix: of two subjects both have one.
    """
    prefix, name = _split(label)
    for kind, other in groups.get(name, []):
        if not prefix or other in (prefix, ""):
            return kind
    match = QUANTITY.search(name)
    return "" if match is None or ANATOMICAL.search(name) else BY_NAME[match[1]]


def _up(source: Source, parameters: Parameters) -> tuple[Up, str]:
    """The direction that points up by the file, and why it is taken."""
    axis = next(iter(parameters.texts("POINT:Y_SCREEN")), "")
    if not axis:
        source.warn("it does not say which axis points up (POINT:Y_SCREEN): z is taken; pass up= otherwise")
        return "z", "as is usual"
    up: Any = axis.lower().lstrip("+")
    if up not in UPS:
        raise source.error(f"POINT:Y_SCREEN: expected +X, +Y, +Z, -X, -Y or -Z, found {axis[:40]!r}: pass up=")
    return up, "by POINT:Y_SCREEN"
