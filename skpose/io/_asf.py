"""Acclaim skeleton files (ASF), the format of the CMU database.

A bone b of an ASF file rotates with its own dofs, in axes C_b that the file gives in global coordinates: its world
rotation is R_b = R_parent · C_b · M_b · C_bᵀ, where M_b is the product of its dofs' rotations, and its far end is at
R_b · direction · length from its near end. In the terms of `Bone` the joint's own axes are H_b = R_b · C_b, so that the
rest rotation is C_parentᵀ · C_b and the offset C_bᵀ · direction · length. Euler angles are extrinsic in the order of
the bone's `axis` line.
"""

from copy import copy
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.units import complaint_of_size
from skpose.io._conventions import check_options, choose_scale
from skpose.io._source import NUMBER, Readable, Source, Token, open_source
from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._rest import size_of

INCH = 0.0254  # m; the unit of length of the format, divided by the file's `length`
ROTATIONS = ("rx", "ry", "rz")
CHANNELS = ("tx", "ty", "tz", *ROTATIONS)
KEYWORDS = {":version", ":name", ":units", ":documentation", ":root", ":bonedata", ":hierarchy", ":skin"}

Statements = list[list[Token]]


@dataclass
class AcclaimBone:
    """One begin … end block of :bonedata."""

    direction: np.ndarray  # of length 1
    length: float  # in the file's unit
    axis: Rotation  # C_b
    order: str
    dofs: list[str]
    limits: list[float]  # low and high of each dof, in the file's unit of angles


@dataclass
class AcclaimRoot:
    """The :root section."""

    channels: list[str] = field(default_factory=lambda: list(CHANNELS))  # in the order of the AMC file's numbers
    axes: str = "xyz"  # of its rotations
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))  # in the file's unit
    orientation: np.ndarray = field(default_factory=lambda: np.zeros(3))  # about x, y, z, in the file's unit


class AsfFile:
    """An ASF file that is read once and serves any number of AMC files, as `asf` of `load_amc` and `load_motion`.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    scale : float, default=None
        Metres per unit of length, as in `load_asf`.

    Attributes
    ----------
    name : str
        The file's name, without its folder.
    scale : float
        Metres per unit of length.
    skeleton : Skeleton
        The skeleton that `load_asf` returns.
    """

    def __init__(self, path: Readable | Source, *, scale: float | None = None):
        check_options(scale=scale)
        source = open_source(path, "an ASF file")
        self.name = Path(source.name).name
        sections = _sections(source)
        units = {tokens[0].lower(): tokens for tokens in sections["units"]}
        angle = units.get("angle", [])
        unit = angle[-1].lower()[:3] if angle else ""
        if angle and unit not in ("deg", "rad"):
            raise source.error(f"angle: expected deg or rad, found {angle[-1][:40]!r}", angle[-1])
        self.radians = unit == "rad" if angle else None  # None if the file does not state the unit
        self.scale = scale = _read_scale(source, units, scale)
        self.root = _read_root(source, sections["root"])
        with source.format_errors():
            self.bones = _read_bones(source, sections["bonedata"], bool(self.radians))
            self.parents = _read_hierarchy(source, sections["hierarchy"], self.bones)
            self.skeleton = self._skeleton()
            source.warn(complaint_of_size(size_of(self.skeleton), scale))

    @property
    def channels(self) -> dict[str, list[str]]:
        """Channels of the root and of each bone with dofs, in the order of the numbers in an AMC file."""
        return {"root": self.root.channels} | {name: bone.dofs for name, bone in self.bones.items() if bone.dofs}

    def with_three_dofs(self) -> "AsfFile":
        """The same with three dofs for every bone that has any: its own first, then the others, without limits."""
        new, new_bones = copy(self), dict[str, AcclaimBone]()
        for name, bone in self.bones.items():
            more = [dof for dof in ROTATIONS if dof not in bone.dofs] if bone.dofs else []
            limits = bone.limits + [-np.inf, np.inf] * len(more) if bone.limits else []
            new_bones[name] = replace(bone, dofs=bone.dofs + more, limits=limits)
        new.bones = new_bones
        new.skeleton = new._skeleton()
        return new

    def _skeleton(self) -> Skeleton:
        return Skeleton([self._bone(name) for name in self.bones])

    def _bone(self, name: str) -> Bone:
        bone, parent = self.bones[name], self.parents[name]
        parent_axis = Rotation.identity() if parent is None else self.bones[parent].axis
        order = [axis for axis in bone.order if f"r{axis}" in bone.dofs]
        limits: np.ndarray | None = None
        if bone.limits:
            pairs = dict(zip(bone.dofs, np.reshape(bone.limits, (-1, 2)), strict=True))
            limits = np.array([pairs[f"r{axis}"] for axis in order])
            limits = limits if self.radians else np.radians(limits)
        rest = (parent_axis.inv() * bone.axis).as_matrix()
        offset = bone.axis.inv().apply(bone.direction * (bone.length * self.scale))
        return Bone(name, parent, tuple(offset), "".join(order), rest, limits)


def _read_scale(source: Source, units: dict[str, list[Token]], given: float | None) -> float:
    """Metres per unit of length."""
    if "length" not in units:
        if given is None:
            raise source.error("expected a length under :units, found none: pass scale=")
        return given
    (length,) = _numbers(source, units["length"], 1, "length")
    if 0.0 < length < np.inf:
        return INCH / length if given is None else choose_scale(source, given, INCH / length, ":units")
    if given is None:
        raise source.error(f"length: expected a positive number, found {length:g}", units["length"][1])
    return given


def load_asf(path: Readable, *, scale: float | None = None) -> Skeleton:
    """Read a skeleton from an Acclaim ASF file.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    scale : float, default=None
        Metres per unit of length. By default that of the file's ``:units length``: one unit is 1/length inch, 0.0564 m
        for the 0.45 of CMU. 1.0 leaves the numbers as they are.

    Returns
    -------
    Skeleton
        Skeleton with one joint at the far end of every bone, named after it, and the file's limits. Bones without
        dofs are rigid.

    Raises
    ------
    MocapFormatError
        If the file is not a complete ASF file; with its name, line and column.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If the skeleton is not of the size of a person, 0.3 to 5 m from end to end in the rest pose.

    See Also
    --------
    load_amc : Read a motion of the skeleton.

    Notes
    -----
    Euler angles are extrinsic in the order of each bone's `axis`, unlike in BVH. The root's own position and
    orientation are not part of a skeleton; `load_amc` adds them to the root's channels.

    Examples
    --------
    >>> from skpose.io import load_asf
    >>> load_asf("02.asf")  # doctest: +SKIP
    Skeleton(n_joints=30, n_dofs=56)
    """
    return AsfFile(path, scale=scale).skeleton


def _sections(source: Source) -> dict[str, Statements]:
    """The file's statements by the keyword of their section."""
    sections: dict[str, Statements] = {}
    section: Statements = []  # of what is before the first keyword
    for tokens in source.statements():
        if tokens[0].startswith(":"):
            section = sections.setdefault(tokens[0][1:].lower(), [])
        else:
            section.append(tokens)
    for keyword in ("units", "root", "bonedata", "hierarchy"):
        if keyword not in sections:
            raise source.error(f"expected a :{keyword} section, found none; is the file cut short?", len(source.lines))
    return sections


def _read_root(source: Source, section: Statements) -> AcclaimRoot:
    root = AcclaimRoot()
    for tokens in section:
        key = tokens[0].lower()
        if key == "order":
            root.channels = _some_of(source, CHANNELS, tokens, "order of the root")
        elif key == "axis":
            root.axes = _axis_order(source, tokens, "axis of the root")
        elif key in ("position", "orientation"):
            setattr(root, key, np.array(_numbers(source, tokens, 3, f"{key} of the root")))
    root.axes = "".join(axis for axis in root.axes if f"r{axis}" in root.channels)
    return root


def _read_bones(source: Source, section: Statements, radians: bool) -> dict[str, AcclaimBone]:
    """The bones, of statements from begin to end."""
    bones: dict[str, AcclaimBone] = {}
    given, key = dict[str, list[Token]](), ""  # the statements of a block by their keys
    for tokens in section:
        word = tokens[0].lower()
        if word == "end":
            name, bone = _read_bone(source, given, tokens[0], radians)
            if name in bones:
                raise source.error(f"bone {name!r} is defined twice", tokens[0])
            bones[name], given = bone, {}
        elif NUMBER.fullmatch(word) or not word[0].isalpha():  # limits, one pair a line, or all in one
            given[key] = [*given.get(key, ()), *tokens]
        else:
            key, given[word] = word, tokens
    if not bones:
        raise source.error("expected begin … end of each bone; is the file cut short?")
    return bones


def _read_bone(source: Source, given: dict[str, list[Token]], end: Token, radians: bool) -> tuple[str, AcclaimBone]:
    """The name and the content of a block; keys that no pose needs, such as id and bodymass, are ignored."""
    for key in ("name", "direction", "length"):
        if key not in given or len(given[key]) < 2:
            raise source.error(f"expected a {key} of the bone that ends here, found none", end)
    name = str(given["name"][1])
    if name == "root" or len(given["name"]) > 2:
        raise source.error("expected a name of one word other than 'root'", given["name"][1])
    direction = np.array(_numbers(source, given["direction"], 3, f"direction of bone {name!r}"))
    (length,) = _numbers(source, given["length"], 1, f"length of bone {name!r}")
    norm = np.linalg.norm(direction)
    if not np.isfinite(norm) or (norm == 0 and length != 0):
        raise source.error(f"bone {name!r} has a length but no direction", given["direction"][0])
    axis, order = Rotation.identity(), "xyz"
    if tokens := given.get("axis"):
        order = _axis_order(source, tokens, f"axis of bone {name!r}")
        angles = dict(zip("xyz", _numbers(source, tokens[:-1], 3, f"axis of bone {name!r}"), strict=True))
        axis = Rotation.from_euler(order, [angles[letter] for letter in order], degrees=not radians)
    dofs = _some_of(source, ROTATIONS, given.get("dof", []), f"dof of bone {name!r}")
    limits = [source.number(token, f"limits of bone {name!r}", finite=False) for token in given.get("limits", [])[1:]]
    if limits and len(limits) != 2 * len(dofs):
        raise source.error(f"bone {name!r}: expected {2 * len(dofs)} limits, found {len(limits)}", end)
    # The direction is printed to six digits, so its length is not exactly 1.
    return name, AcclaimBone(direction / (norm or 1.0), length, axis, order, dofs, limits)


def _numbers(source: Source, tokens: list[Token], n: int, what: str) -> list[float]:
    """The n numbers after a keyword."""
    if len(tokens) != n + 1:
        raise source.error(f"{what}: expected {n} numbers, found {len(tokens) - 1}", tokens[-1] if tokens else None)
    return [source.number(token, what) for token in tokens[1:]]


def _some_of(source: Source, choices: tuple[str, ...], tokens: list[Token], what: str) -> list[str]:
    """The words after a keyword, each one of the choices and none twice."""
    found: list[str] = []
    for token in tokens[1:]:
        if token.lower() not in choices or token.lower() in found:
            raise source.error(f"{what}: expected some of {' '.join(choices)}, found {token[:40]!r}", token)
        found.append(token.lower())
    return found


def _axis_order(source: Source, tokens: list[Token], what: str) -> str:
    order = tokens[-1].lower()
    if sorted(order) != ["x", "y", "z"]:
        raise source.error(f"{what}: expected an order such as XYZ, found {tokens[-1][:40]!r}", tokens[-1])
    return order


def _read_hierarchy(source: Source, section: Statements, bones: dict[str, AcclaimBone]) -> dict[str, str | None]:
    """The parent of every bone, None for the root."""
    parents: dict[str, str | None] = {}
    for parent, *children in section:
        for child in children:
            if parent not in {"root", *bones} or child not in bones or child in parents:
                raise source.error(f"expected bones of :bonedata, each with one parent, found {parent} {child}", child)
            parents[str(child)] = None if parent == "root" else str(parent)
    if missing := bones.keys() - parents.keys():
        raise source.error(f"bone {sorted(missing)[0]!r} does not appear under :hierarchy")
    return parents


def is_asf(source: Source) -> bool:
    return source.first_word in KEYWORDS
