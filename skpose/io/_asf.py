"""Acclaim skeleton files (ASF), the format of the CMU database.

A bone b of an ASF file turns with its own dofs, in axes C_b that the file states in global coordinates: its world
rotation is R_b = R_parent · C_b · M_b · C_bᵀ, where M_b is the product of its dofs' rotations, and its far end is at
R_b · direction · length from its near end. In the terms of `Bone` the joint's own axes are H_b = R_b · C_b, so that the
rest rotation is C_parentᵀ · C_b and the offset C_bᵀ · direction · length. Euler angles are extrinsic in the order that
the bone's `axis` line names.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.io._text import MocapFormatError, PathLike, finite_number, number, read_lines
from skpose.skeleton import Bone, Skeleton

INCH = 0.0254  # m; the unit of length of the format, scaled by the file's `length`


@dataclass
class _AsfBone:
    """One begin … end block of :bonedata."""

    line: int
    name: str = ""
    direction: np.ndarray | None = None
    length: float | None = None
    axis: Rotation = field(default_factory=Rotation.identity)
    order: str = "xyz"
    dofs: list[str] = field(default_factory=list)
    limits: list[float] = field(default_factory=list)


@dataclass
class Asf:
    """What a motion needs of its ASF file."""

    path: Path
    skeleton: Skeleton
    scale: float  # m per unit of length
    radians: bool
    root_channels: list[str]  # in the file's order, such as tx ty tz rx ry rz
    root_axes: str
    dofs: dict[str, list[str]]  # of each bone that has any, in the file's order


def load_asf(path: PathLike, *, scale: float | None = None) -> Skeleton:
    """Read a skeleton from an Acclaim ASF file.

    Parameters
    ----------
    path : str or path-like
        The file.
    scale : float, default=None
        Metres per unit of length. None follows the file's ``:units length``, as CMU's do: one unit is 1/length inch,
        0.0564 m at 0.45.

    Returns
    -------
    Skeleton
        With one joint at the far end of every bone, named after it, and the file's limits. Bones without dofs are
        rigid.

    Raises
    ------
    MocapFormatError
        If the file is not a whole ASF file; with its name and the line.
    OSError
        If it cannot be read.

    See Also
    --------
    load_amc : Read a motion of the skeleton.

    Notes
    -----
    The root's own position and orientation are no part of a pose and are left out.

    Examples
    --------
    >>> from skpose.io import load_asf
    >>> load_asf("02.asf")  # doctest: +SKIP
    Skeleton(n_joints=30, n_dofs=56)
    """
    return read_asf(path, scale).skeleton


def read_asf(path: PathLike, scale: float | None = None) -> Asf:
    lines = read_lines(path, "an ASF file")
    sections = _sections(lines, path)
    units = {tokens[0].lower(): (number_, tokens[1:]) for number_, tokens in sections["units"]}
    radians = _is_radians(units.get("angle"), path)
    if scale is None:
        if "length" not in units:
            raise MocapFormatError(path, None, "no length under :units; pass scale=, the metres per unit of length")
        line, tokens = units["length"]
        unit = finite_number(tokens[0] if tokens else "", path, line, "length")
        if unit <= 0:
            raise MocapFormatError(path, line, f"length: expected a positive number, found {tokens[0]!r}")
        scale = INCH / unit
    root_channels, root_axes = _read_root(sections["root"], path)
    bones = _read_bones(sections["bonedata"], radians, path)
    parents = _read_hierarchy(sections["hierarchy"], bones, path)
    for name, bone in bones.items():
        if name not in parents:
            raise MocapFormatError(path, bone.line, f"bone {name!r} has no place under :hierarchy")
    made = []
    for name, bone in bones.items():
        parent = parents[name]
        before = Rotation.identity() if parent is None else bones[parent].axis
        order = [axis for axis in bone.order if f"r{axis}" in bone.dofs]
        limits = None
        if bone.limits:
            pairs = dict(zip(bone.dofs, np.reshape(bone.limits, (-1, 2)), strict=True))
            limits = [pairs[f"r{axis}"] for axis in order]
            limits = limits if radians else np.radians(limits)
        rest = (before.inv() * bone.axis).as_matrix()
        offset = bone.axis.inv().apply(bone.direction * (bone.length * scale))
        made.append(Bone(name, parent, tuple(offset), "".join(order), rest, limits))
    try:
        skeleton = Skeleton(made)
    except ValueError as error:
        raise MocapFormatError(path, None, str(error)) from None
    dofs = {name: bone.dofs for name, bone in bones.items() if bone.dofs}
    return Asf(Path(path), skeleton, scale, radians, root_channels, root_axes, dofs)


def _sections(lines: list[str], path: PathLike) -> dict[str, list[tuple[int, list[str]]]]:
    """The file's lines as (number, tokens), under the keyword of their section; comments and brackets taken out."""
    sections: dict[str, list[tuple[int, list[str]]]] = {}
    section: list[tuple[int, list[str]]] | None = None
    for line, text in enumerate(lines, start=1):
        tokens = text.split("#")[0].replace("(", " ").replace(")", " ").split()
        if not tokens:
            continue
        if tokens[0].startswith(":"):
            section = sections.setdefault(tokens[0][1:].lower(), [])
        elif section is None:
            raise MocapFormatError(path, line, f"expected a keyword such as :version, found {text.strip()!r}; not ASF?")
        else:
            section.append((line, tokens))
    for keyword in ("units", "root", "bonedata", "hierarchy"):
        if keyword not in sections:
            raise MocapFormatError(
                path, len(lines), f"the file ends without a :{keyword} section; not ASF, or cut short"
            )
    return sections


def _is_radians(entry: tuple[int, list[str]] | None, path: PathLike) -> bool:
    line, tokens = entry or (None, ["deg"])
    unit = tokens[0].lower() if tokens else ""
    if not unit.startswith(("deg", "rad")):
        raise MocapFormatError(path, line, f"angle: expected deg or rad, found {unit!r}")
    return unit.startswith("rad")


def _read_root(section: list[tuple[int, list[str]]], path: PathLike) -> tuple[list[str], str]:
    """The root's channels in the order of the AMC file's numbers, and the order of its rotation."""
    channels, axes = ["tx", "ty", "tz", "rx", "ry", "rz"], "xyz"
    for line, tokens in section:
        key, values = tokens[0].lower(), [token.lower() for token in tokens[1:]]
        if key == "order":
            channels = values
            if not set(channels) <= {"tx", "ty", "tz", "rx", "ry", "rz"} or len(set(channels)) < len(channels):
                raise MocapFormatError(
                    path, line, f"order: expected some of TX TY TZ RX RY RZ, found {' '.join(values)}"
                )
        elif key == "axis":
            axes = _axis_order(values, path, line)
    return channels, "".join(axis for axis in axes if f"r{axis}" in channels)


def _axis_order(tokens: list[str], path: PathLike, line: int) -> str:
    order = tokens[-1].lower() if tokens else ""
    if sorted(order) != ["x", "y", "z"]:
        raise MocapFormatError(
            path, line, f"axis: expected an order such as XYZ at the end, found {' '.join(tokens)!r}"
        )
    return order


def _read_bones(section: list[tuple[int, list[str]]], radians: bool, path: PathLike) -> dict[str, _AsfBone]:
    bones: dict[str, _AsfBone] = {}
    bone: _AsfBone | None = None
    key = ""
    for line, tokens in section:
        word = tokens[0].lower()
        if word == "begin":
            bone, key = _AsfBone(line), ""
            continue
        if bone is None:
            raise MocapFormatError(path, line, f"expected begin, found {' '.join(tokens)!r}")
        if word == "end":
            _check_bone(bone, path, line)
            if bone.name in bones:
                raise MocapFormatError(path, bone.line, f"bone {bone.name!r} is defined twice")
            bones[bone.name] = bone
            bone = None
            continue
        if word[0].isalpha() and word not in ("inf", "nan"):
            key, tokens = word, tokens[1:]
        what = f"{key} of bone {bone.name!r}"
        if key == "name":
            bone.name = " ".join(tokens)
        elif key == "direction":
            bone.direction = np.array(
                [finite_number(t, path, line, what) for t in _exactly(3, tokens, path, line, what)]
            )
        elif key == "length":
            bone.length = finite_number(_exactly(1, tokens, path, line, what)[0], path, line, what)
        elif key == "axis":
            bone.order = _axis_order(tokens, path, line)
            angles = [finite_number(t, path, line, what) for t in _exactly(4, tokens, path, line, what)[:3]]
            bone.axis = Rotation.from_euler(
                bone.order, [angles["xyz".index(axis)] for axis in bone.order], degrees=not radians
            )
        elif key == "dof":
            bone.dofs = [token.lower() for token in tokens]
            if not set(bone.dofs) <= {"rx", "ry", "rz"} or len(set(bone.dofs)) < len(bone.dofs):
                raise MocapFormatError(path, line, f"{what}: expected some of rx ry rz, found {' '.join(tokens)!r}")
        elif key == "limits":  # one pair a line
            bone.limits += [number(t, path, line, what) for t in _exactly(2, tokens, path, line, what)]
    if bone is not None:
        raise MocapFormatError(
            path, bone.line, f"bone {bone.name!r} begins here and has no end; is the file cut short?"
        )
    if not bones:
        raise MocapFormatError(path, None, "there are no bones under :bonedata")
    return bones


def _exactly(n: int, tokens: list[str], path: PathLike, line: int, what: str) -> list[str]:
    if len(tokens) != n:
        raise MocapFormatError(path, line, f"{what}: expected {n} values, found {len(tokens)}: {' '.join(tokens)!r}")
    return tokens


def _check_bone(bone: _AsfBone, path: PathLike, line: int) -> None:
    for key in ("name", "direction", "length"):
        value = getattr(bone, key)
        if value is None or (key == "name" and not value):
            raise MocapFormatError(path, line, f"bone {bone.name!r}, begun in line {bone.line}, has no {key}")
    if bone.name == "root":
        raise MocapFormatError(path, line, "a bone is named 'root', which is the name of the root; call it otherwise")
    norm = np.linalg.norm(bone.direction)
    if norm == 0 and bone.length != 0:
        raise MocapFormatError(path, line, f"bone {bone.name!r} has a length but no direction")
    bone.direction = bone.direction / (norm or 1.0)  # printed to six digits; the length is what counts
    if bone.limits and len(bone.limits) != 2 * len(bone.dofs):
        raise MocapFormatError(
            path, line, f"bone {bone.name!r} has {len(bone.limits) // 2} pairs of limits for {len(bone.dofs)} dofs"
        )


def _read_hierarchy(section: list[tuple[int, list[str]]], bones: dict[str, _AsfBone], path: PathLike) -> dict:
    """Parent of every bone, None for the root."""
    parents: dict[str, str | None] = {}
    for line, (parent, *children) in section:
        if not children and parent.lower() in ("begin", "end"):
            continue
        if parent not in bones and parent != "root":
            raise MocapFormatError(
                path,
                line,
                f"bone {children[0] if children else ''!r} hangs on {parent!r}, which the file does not define",
            )
        for child in children:
            if child not in bones:
                raise MocapFormatError(
                    path, line, f"bone {child!r} hangs on {parent!r}, but the file does not define it"
                )
            if child in parents:
                raise MocapFormatError(path, line, f"bone {child!r} hangs on {parents[child] or 'root'!r} already")
            parents[child] = None if parent == "root" else parent
    return parents
