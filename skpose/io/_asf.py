"""Acclaim skeleton files (ASF), the format of the CMU database.

A bone b of an ASF file turns with its own dofs, in axes C_b that the file states in global coordinates: its world
rotation is R_b = R_parent · C_b · M_b · C_bᵀ, where M_b is the product of its dofs' rotations, and its far end is at
R_b · direction · length from its near end. In the terms of `Bone` the joint's own axes are H_b = R_b · C_b, so that the
rest rotation is C_parentᵀ · C_b and the offset C_bᵀ · direction · length. Euler angles are extrinsic in the order that
the bone's `axis` line names.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.io._source import NUMBER, Readable, Source, Token, check_positive
from skpose.skeleton import Bone, Skeleton

INCH = 0.0254  # m; the unit of length of the format, scaled by the file's `length`
TURNS = ("rx", "ry", "rz")
CHANNELS = ("tx", "ty", "tz", *TURNS)

Statements = list[list[Token]]


@dataclass
class _AsfBone:
    """One begin … end block of :bonedata."""

    begin: Token
    name: str = ""
    direction: np.ndarray | None = None
    length: float | None = None
    axis: Rotation = field(default_factory=Rotation.identity)
    order: str = "xyz"
    dofs: list[str] = field(default_factory=list)
    limits: list[float] = field(default_factory=list)


@dataclass
class _Root:
    """The :root section."""

    channels: list[str] = field(default_factory=lambda: list(CHANNELS))  # in the order of the AMC file's numbers
    order: str = "xyz"
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))  # in the file's unit
    orientation: np.ndarray = field(default_factory=lambda: np.zeros(3))  # about x, y, z, in the file's unit

    @property
    def axes(self) -> str:
        return "".join(axis for axis in self.order if f"r{axis}" in self.channels)


@dataclass
class Asf:
    """What a motion needs of its ASF file."""

    name: str
    bones: dict[str, _AsfBone]
    parents: dict[str, str | None]
    scale: float  # m per unit of length
    radians: bool | None  # None where the file does not say
    root: _Root

    @property
    def dofs(self) -> dict[str, list[str]]:
        """Of each bone that has any, in the file's order."""
        return {name: bone.dofs for name, bone in self.bones.items() if bone.dofs}

    def skeleton(self) -> Skeleton:
        made = []
        for name, bone in self.bones.items():
            parent = self.parents[name]
            before = Rotation.identity() if parent is None else self.bones[parent].axis
            order = [axis for axis in bone.order if f"r{axis}" in bone.dofs]
            limits = None
            if bone.limits:
                pairs = dict(zip(bone.dofs, np.reshape(bone.limits, (-1, 2)), strict=True))
                limits = np.array([pairs[f"r{axis}"] for axis in order])
                limits = limits if self.radians else np.radians(limits)
            rest = (before.inv() * bone.axis).as_matrix()
            offset = bone.axis.inv().apply(bone.direction * (bone.length * self.scale))
            made.append(Bone(name, parent, tuple(offset), "".join(order), rest, limits))
        return Skeleton(made)

    def with_three_dofs(self) -> "Asf":
        """Every bone that turns at all about all three axes: its own first, then the others, without limits."""
        bones = {}
        for name, bone in self.bones.items():
            more = [dof for dof in TURNS if dof not in bone.dofs] if bone.dofs else []
            limits = bone.limits + [-np.inf, np.inf] * len(more) if bone.limits else []
            bones[name] = replace(bone, dofs=bone.dofs + more, limits=limits)
        return replace(self, bones=bones)


def load_asf(path: Readable, *, scale: float | None = None) -> Skeleton:
    """Read a skeleton from an Acclaim ASF file.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    scale : float, default=None
        Metres per unit of length. None follows the file's ``:units length``, as CMU's do: one unit is 1/length inch,
        0.0564 m at 0.45. 1.0 leaves the file's numbers as they are.

    Returns
    -------
    Skeleton
        With one joint at the far end of every bone, named after it, and the file's limits. Bones without dofs are
        rigid.

    Raises
    ------
    MocapFormatError
        If the file is not a whole ASF file; with its name, the line and the column.
    OSError
        If it cannot be read.

    See Also
    --------
    load_amc : Read a motion of the skeleton.

    Notes
    -----
    Euler angles are extrinsic in the order of each bone's `axis`, unlike those of BVH. The root's own position and
    orientation are no part of a skeleton; `load_amc` adds them to the root's channels.

    Examples
    --------
    >>> from skpose.io import load_asf
    >>> load_asf("02.asf")  # doctest: +SKIP
    Skeleton(n_joints=30, n_dofs=56)
    """
    with Source(path, "an ASF file") as source, source.blamed():
        return read_asf(source, scale).skeleton()


def read_asf(source: Source, scale: float | None = None) -> Asf:
    if scale is not None:
        check_positive("scale", scale)
    sections = _sections(source)
    units = {tokens[0].lower(): tokens for tokens in sections["units"]}
    radians = _is_radians(units.get("angle"), source)
    if scale is None:
        if "length" not in units:
            raise source.error("no length under :units; pass scale=, the metres per unit of length")
        (unit,) = _numbers(1, units["length"], source, "length", positive=True)
        scale = INCH / unit
    root = _read_root(sections["root"], source)
    bones = _read_bones(sections["bonedata"], bool(radians), source)
    parents = _read_hierarchy(sections["hierarchy"], bones, source)
    for name, bone in bones.items():
        if name not in parents:
            raise source.error(f"bone {name!r} has no place under :hierarchy", bone.begin)
    asf = Asf(Path(source.name).name, bones, parents, scale, radians, root)
    with source.blamed():
        asf.skeleton()
    return asf


def _sections(source: Source) -> dict[str, Statements]:
    """The file's statements under the keyword of their section."""
    sections: dict[str, Statements] = {}
    section: Statements | None = None
    for tokens in source.statements():
        if tokens[0].startswith(":"):
            section = sections.setdefault(tokens[0][1:].lower(), [])
        elif section is None:
            raise source.error(
                f"expected a keyword such as :version, found {str(tokens[0][:40])!r}; not an ASF file?", tokens[0]
            )
        else:
            section.append(tokens)
    for keyword in ("units", "root", "bonedata", "hierarchy"):
        if keyword not in sections:
            raise source.error(f"the file ends without a :{keyword} section; not ASF, or cut short", source.line)
    return sections


def _is_radians(tokens: list[Token] | None, source: Source) -> bool | None:
    if tokens is None:
        return None
    unit = tokens[1].lower() if len(tokens) > 1 else ""
    if not unit.startswith(("deg", "rad")):
        raise source.error(f"angle: expected deg or rad, found {unit[:40]!r}", tokens[-1])
    return unit.startswith("rad")


def _read_root(section: Statements, source: Source) -> _Root:
    root = _Root()
    for tokens in section:
        key = tokens[0].lower()
        if key == "order":
            root.channels = _some_of(CHANNELS, tokens, source, "order of the root")
        elif key == "axis":
            root.order = _axis_order(tokens, source, "axis of the root")
        elif key in ("position", "orientation"):
            setattr(root, key, np.array(_numbers(3, tokens, source, f"{key} of the root")))
    return root


def _read_bones(section: Statements, radians: bool, source: Source) -> dict[str, _AsfBone]:
    bones: dict[str, _AsfBone] = {}
    bone: _AsfBone | None = None
    key: str | None = None
    for tokens in section:
        word = tokens[0].lower()
        if word == "begin":
            if bone is not None:
                raise source.error(f"bone {bone.name!r}, begun in line {bone.begin.line}, has no end", tokens[0])
            bone, key = _AsfBone(tokens[0]), None
        elif bone is None:
            raise source.error(f"expected begin, found {str(tokens[0][:40])!r}", tokens[0])
        elif word == "end":
            _check_bone(bone, tokens[0], source)
            if bone.name in bones:
                raise source.error(f"bone {bone.name!r} is defined twice", bone.begin)
            bones[bone.name] = bone
            bone = None
        elif key == "limits" and (NUMBER.fullmatch(word) or not word[0].isalpha()):  # one pair a line, or all in one
            _read_key("limits", bone, [key, *tokens], radians, source)
        else:
            key = tokens[0].lower()
            _read_key(key, bone, tokens, radians, source)
    if bone is not None:
        raise source.error(f"bone {bone.name!r} begins here and has no end; is the file cut short?", bone.begin)
    if not bones:
        raise source.error("there are no bones under :bonedata")
    return bones


def _read_key(key: str, bone: _AsfBone, tokens: list[Token], radians: bool, source: Source) -> None:
    """What one statement says of a bone; those that no pose needs, such as id and bodymass, are passed over."""
    what = f"{key} of bone {bone.name!r}"
    if key == "name":
        if len(tokens) != 2:
            raise source.error(f"name of a bone: expected one word, found {' '.join(tokens[1:])[:40]!r}", tokens[-1])
        bone.name = str(tokens[1])
    elif key == "direction":
        bone.direction = np.array(_numbers(3, tokens, source, what))
    elif key == "length":
        (bone.length,) = _numbers(1, tokens, source, what)
    elif key == "axis":
        bone.order = _axis_order(tokens, source, what)
        angles = dict(zip("xyz", _numbers(3, tokens[:-1], source, what), strict=True))
        bone.axis = Rotation.from_euler(bone.order, [angles[axis] for axis in bone.order], degrees=not radians)
    elif key == "dof":
        bone.dofs = _some_of(TURNS, tokens, source, what)
    elif key == "limits":
        bone.limits += [source.number(token, what, finite=False) for token in tokens[1:]]


def _numbers(n: int, tokens: list[Token], source: Source, what: str, positive: bool = False) -> list[float]:
    """The n numbers after a keyword."""
    if len(tokens) != n + 1:
        raise source.error(f"{what}: expected {n} numbers, found {len(tokens) - 1}", tokens[-1])
    return [(source.positive if positive else source.number)(token, what) for token in tokens[1:]]


def _some_of(choices: tuple[str, ...], tokens: list[Token], source: Source, what: str) -> list[str]:
    """The words after a keyword, each one of the choices and none twice."""
    found: list[str] = []
    for token in tokens[1:]:
        if token.lower() not in choices or token.lower() in found:
            raise source.error(
                f"{what}: expected some of {' '.join(choices)}, each once, found {str(token[:40])!r}", token
            )
        found.append(token.lower())
    return found


def _axis_order(tokens: list[Token], source: Source, what: str) -> str:
    order = tokens[-1].lower()
    if sorted(order) != ["x", "y", "z"]:
        raise source.error(
            f"{what}: expected an order such as XYZ at the end, found {str(tokens[-1][:40])!r}", tokens[-1]
        )
    return order


def _check_bone(bone: _AsfBone, end: Token, source: Source) -> None:
    for key in ("name", "direction", "length"):
        value = getattr(bone, key)
        if value is None or (key == "name" and not value):
            raise source.error(f"bone {bone.name!r}, begun in line {bone.begin.line}, has no {key}", end)
    if bone.name == "root":
        raise source.error("a bone is named 'root', which is the name of the root; call it otherwise", bone.begin)
    with source.blamed():
        norm = np.linalg.norm(bone.direction)
    if not np.isfinite(norm) or (norm == 0 and bone.length != 0):
        raise source.error(f"bone {bone.name!r} has a length but no direction", bone.begin)
    bone.direction = bone.direction / (norm or 1.0)  # printed to six digits; the length is what counts
    if bone.limits and len(bone.limits) != 2 * len(bone.dofs):
        raise source.error(
            f"bone {bone.name!r}: expected a pair of limits for each of its {len(bone.dofs)} dofs, found "
            f"{len(bone.limits)} numbers",
            end,
        )


def _read_hierarchy(section: Statements, bones: dict[str, _AsfBone], source: Source) -> dict[str, str | None]:
    """Parent of every bone, None for the root."""
    parents: dict[str, str | None] = {}
    for parent, *children in section:
        if not children and parent.lower() in ("begin", "end"):
            continue
        if parent not in bones and parent != "root":
            child = str(children[0]) if children else ""
            raise source.error(f"bone {child!r} hangs on {str(parent)!r}, which the file does not define", parent)
        for child in children:
            if child not in bones:
                raise source.error(
                    f"bone {str(child)!r} hangs on {str(parent)!r}, but the file does not define it", child
                )
            if child in parents:
                raise source.error(f"bone {str(child)!r} hangs on {parents[child] or 'root'!r} already", child)
            parents[str(child)] = None if parent == "root" else str(parent)
    return parents
