"""Acclaim skeleton files (ASF) and motion files (AMC), the formats of the CMU database.

A bone b of an ASF file rotates with its own dofs, in axes C_b that the file gives in global coordinates: its world
rotation is R_b = R_parent · C_b · M_b · C_bᵀ, where M_b is the product of its dofs' rotations, and its far end is at
R_b · direction · length from its near end. In the terms of `Bone` the joint's own axes are H_b = R_b · C_b, so that the
rest rotation is C_parentᵀ · C_b and the offset C_bᵀ · direction · length. Euler angles are extrinsic in the order of
the bone's `axis` line.
"""

import os
import re
from collections.abc import Sequence
from copy import copy
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.units import complaint_of_size
from skpose._utils.warnings import warn
from skpose.io._conventions import Up, check_options, choose_scale, stand
from skpose.io._source import NUMBER, WHOLE, PathLike, Readable, Source, Token, drop_not_finite, open_source, parse
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._rest import size_of

INCH = 0.0254  # m; the unit of length of the format, divided by the file's `length`
ROTATIONS = ("rx", "ry", "rz")
UNLIMITED = (-np.inf, np.inf)
CHANNELS = ("tx", "ty", "tz", *ROTATIONS)
KEYWORDS = {":version", ":name", ":units", ":documentation", ":root", ":bonedata", ":hierarchy", ":skin"}

# The statements of a root that states nothing.
ROOT = {"order": ("order", *CHANNELS), "axis": ("axis", "xyz"), **{k: (k, *"000") for k in ("position", "orientation")}}

Statements = list[list[Token]]


class AcclaimBone(NamedTuple):
    """One begin … end block of :bonedata."""

    direction: np.ndarray  # of length 1
    length: float  # in the file's unit
    axis: Rotation  # C_b
    order: str
    dofs: list[str]
    limits: dict[str, np.ndarray]  # low and high of each dof, rad; none if the file has none


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
        root: dict[str, Sequence[Any]] = ROOT | {tokens[0].lower(): tokens for tokens in sections["root"]}
        self.root_channels = _some_of(source, CHANNELS, root["order"], "order of the root")  # as numbers in AMC files
        order = _axis_order(source, root["axis"], "axis of the root")
        self.root_axes = "".join(axis for axis in order if f"r{axis}" in self.root_channels)
        # In the file's units; the orientation is about x, y and z.
        self.root_position, self.root_orientation = (
            np.array(_numbers(source, root[key], 3, f"{key} of the root")) for key in ("position", "orientation")
        )
        with source.format_errors():
            self.bones = _read_bones(source, sections["bonedata"], bool(self.radians))
            self.parents = _read_hierarchy(source, sections["hierarchy"], self.bones)
            self.skeleton = self._skeleton()
            source.warn(complaint_of_size(size_of(self.skeleton), scale))

    @property
    def channels(self) -> dict[str, list[str]]:
        """Channels of the root and of each bone with dofs, in the order of the numbers in an AMC file."""
        return {"root": self.root_channels} | {name: bone.dofs for name, bone in self.bones.items() if bone.dofs}

    def with_three_dofs(self) -> "AsfFile":
        """The same with three dofs for every bone that has any: its own first, then the others, without limits."""
        new = copy(self)
        new.bones = {
            name: bone._replace(dofs=list(dict.fromkeys([*bone.dofs, *ROTATIONS])) if bone.dofs else [])
            for name, bone in self.bones.items()
        }
        new.skeleton = new._skeleton()
        return new

    def _skeleton(self) -> Skeleton:
        return Skeleton([self._bone(name) for name in self.bones])

    def _bone(self, name: str) -> Bone:
        bone, parent = self.bones[name], self.parents[name]
        parent_axis = Rotation.identity() if parent is None else self.bones[parent].axis
        order = [axis for axis in bone.order if f"r{axis}" in bone.dofs]
        limits = np.array([bone.limits.get(f"r{axis}", UNLIMITED) for axis in order]) if bone.limits else None
        rest = (parent_axis.inv() * bone.axis).as_matrix()
        offset = bone.axis.inv().apply(bone.direction * (bone.length * self.scale))
        return Bone(name, parent, tuple(offset), "".join(order), rest, limits)


def _read_scale(source: Source, units: dict[str, list[Token]], given: float | None) -> float:
    """Metres per unit of length."""
    length, at = np.nan, None
    if tokens := units.get("length"):
        (length,), at = _numbers(source, tokens, 1, "length"), tokens[-1]
    is_known = 0.0 < length < np.inf
    if given is None and not is_known:
        raise source.error(f"length under :units: expected a positive number, found {length:g}: pass scale=", at)
    if given is None:
        return INCH / length
    return choose_scale(source, given, INCH / length, ":units") if is_known else given


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
    tokens = given.get("axis", ["axis", "0", "0", "0", "xyz"])
    order = _axis_order(source, tokens, f"axis of bone {name!r}")
    angles = dict(zip("xyz", _numbers(source, tokens[:-1], 3, f"axis of bone {name!r}"), strict=True))
    axis = Rotation.from_euler(order, [angles[letter] for letter in order], degrees=not radians)
    dofs = _some_of(source, ROTATIONS, given.get("dof", []), f"dof of bone {name!r}")
    ends = [source.number(token, f"limits of bone {name!r}", finite=False) for token in given.get("limits", [])[1:]]
    if ends and len(ends) != 2 * len(dofs):
        raise source.error(f"bone {name!r}: expected {2 * len(dofs)} limits, found {len(ends)}", end)
    limits = dict(zip(dofs, np.reshape(ends if radians else np.radians(ends), (-1, 2)), strict=False))
    # The direction is printed to six digits, so its length is not exactly 1.
    return name, AcclaimBone(direction / (norm or 1.0), length, axis, order, dofs, limits)


def _numbers(source: Source, tokens: Sequence[Any], n: int, what: str) -> list[float]:
    """The n numbers after a keyword."""
    if len(tokens) != n + 1:
        raise source.error(f"{what}: expected {n} numbers, found {len(tokens) - 1}", tokens[-1] if tokens else None)
    return [source.number(token, what) for token in tokens[1:]]


def _some_of(source: Source, choices: tuple[str, ...], tokens: Sequence[Any], what: str) -> list[str]:
    """The words after a keyword, each one of the choices and none twice."""
    found: list[str] = []
    for token in tokens[1:]:
        if token.lower() not in choices or token.lower() in found:
            raise source.error(f"{what}: expected some of {' '.join(choices)}, found {token[:40]!r}", token)
        found.append(token.lower())
    return found


def _axis_order(source: Source, tokens: Sequence[Any], what: str) -> str:
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


# --- motions ----------------------------------------------------------------------------------------------------------
# A frame is a line for its number, and one for the name and the numbers of each bone.


Line = tuple[int, str]  # its number, and its text without a comment
USUAL_RATE = 120.0  # Hz, of CMU and HDM05
KEYWORD = re.compile(r":[a-z][\w-]*", re.ASCII | re.IGNORECASE)  # such as :degrees and :fully-specified
NUMERIC = re.compile(r"[+-]?[.\d]|nan|[+-]?inf", re.ASCII | re.IGNORECASE)  # how a number begins, also a damaged one


def load_amc(
    path: Readable,
    asf: Readable | AsfFile | None = None,
    *,
    frame_rate: float | None = None,
    scale: float | None = None,
    on_nan: Literal["raise", "drop"] = "raise",
    missing: Literal["raise", "rest"] = "raise",
    up: Up | None = None,
) -> Motion:
    """Read a motion from an Acclaim AMC file and the ASF file of its skeleton.

    Parameters
    ----------
    path : str, path-like or file
        The AMC file, or an open one; compressed by gzip or not.
    asf : str, path-like, file or AsfFile, default=None
        The ASF file of its skeleton. By default walk.asf in the folder of walk.amc, or 02.asf for 02_01.amc, or
        HDM_bd.asf for HDM_bd_walk_001_120.amc.
    frame_rate : float, default=None
        Frames per second, Hz; the format does not store it. By default 120 Hz, the usual rate of CMU and HDM05, with a
        warning.
    scale : float, default=None
        Metres per unit of length, as in `load_asf`.
    on_nan : {"raise", "drop"}, default="raise"
        Refuse a file with NaN or infinite numbers, or leave these frames out. The other frames keep their numbers and
        times, see `Motion.frame_numbers`.
    missing : {"raise", "rest"}, default="raise"
        Refuse a file in which a frame does not mention a bone, or set the angles of the bone to zero.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The axis of the file's world that points up, as in `load_bvh`.

    Returns
    -------
    Motion
        Motion with the angles in rad, assigned to columns by name, and the skeleton of the ASF file. If the AMC file
        states ``:FORCE-ALL-JOINTS-BE-3DOF``, every bone that has dofs has three.

    Raises
    ------
    MocapFormatError
        If a file is damaged, or the two do not belong together; with its name and line.
    OSError
        If one cannot be read, or the ASF file is not found.

    Warns
    -----
    UserWarning
        If no frame rate is given. The text is the same for every file, so that Python shows it once.

    See Also
    --------
    save_bvh : Write the motion in a format that most programs read.

    Notes
    -----
    The root's position and orientation in the ASF file are added to the root's numbers. The numbers of bones without
    dofs must be zero.

    Examples
    --------
    >>> from skpose.io import load_amc
    >>> load_amc("02_01.amc", "02.asf", frame_rate=120)  # doctest: +SKIP
    Motion(343 frames at 120 Hz, 2.9 s, y up, Skeleton(n_joints=30, n_dofs=56))
    """
    check_options(frame_rate=frame_rate, scale=scale, on_nan=on_nan, missing=missing, up=up)
    source = open_source(path, "an AMC file")
    if asf is None:
        asf = asf_path(source.name)
        if not os.path.lexists(asf):
            raise FileNotFoundError(f"{source.name} needs its skeleton, and there is no {asf}: pass asf=")
    if not isinstance(asf, AsfFile):
        asf = AsfFile(asf, scale=scale)
    elif scale not in (None, asf.scale):
        raise ValueError(f"scale must be that of {asf.name}, {asf.scale}, or None, got {scale!r}")
    texts = (line.partition("#")[0] for line in source.lines)
    lines = [(number, text) for number, text in enumerate(texts, 1) if text and not text.isspace()]
    n_keywords = next((i for i, (_, text) in enumerate(lines) if not text.lstrip().startswith(":")), len(lines))
    keywords = {text.split()[0].lower(): line for line, text in lines[:n_keywords]}
    unit = next((word for word in keywords if word in (":degrees", ":radians")), None)
    in_radians = bool(asf.radians) if unit is None else unit == ":radians"
    if unit and asf.radians not in (None, in_radians):
        raise source.error(f"angles in {unit[1:]}, but {asf.name} has the other unit", keywords[unit])
    if ":force-all-joints-be-3dof" in keywords:
        asf = asf.with_three_dofs()
    rows = _read_rows(source, asf, lines[n_keywords:], fill=missing == "rest", finite=on_nan == "raise")
    numbers, frames = drop_not_finite(rows, np.arange(len(rows)), source)
    with source.format_errors():
        motion = _motion(numbers, frames, asf, in_radians, frame_rate or USUAL_RATE)
    if frame_rate is None:
        warn(
            f"AMC files do not state their frame rate: {USUAL_RATE:g} Hz is taken, the usual rate of CMU and HDM05; "
            "pass frame_rate=, in Hz"
        )
    return stand(motion, up, source)


def is_amc(source: Source) -> bool:
    """Whether a file begins with a keyword, or with the number of a frame and a bone with numbers."""
    lines = [words for line in source.head.splitlines()[:1000] if (words := line.partition("#")[0].split())]
    if not lines:
        return "#" in source.head  # comments, which the other formats do not have
    bone = lines[1] if len(lines) > 1 else []
    is_frame = len(lines[0]) == 1 and WHOLE.fullmatch(lines[0][0]) and (len(bone) < 2 or NUMERIC.match(bone[1]))
    return bool(KEYWORD.fullmatch(lines[0][0]) or is_frame)


def asf_path(amc: PathLike) -> Path:
    """The path at which the ASF file of an AMC file is expected.

    It is walk.asf in the folder of walk.amc if there is such a file; otherwise the name is cut at its last underscore,
    02.asf for 02_01.amc as in the CMU database, then at the one before it, and so on: HDM_bd.asf for
    HDM_bd_walk_001_120.amc. For a link, the file that it points to is tried too. If none exists, it is 02.asf.
    """
    amc = Path(amc)
    candidates = (asf for path in (amc, Path(os.path.realpath(amc))) for asf in _asf_paths(path))
    found = (path for path in candidates if os.path.lexists(path) and not path.is_dir())
    return next(found, _asf_paths(amc)[:2][-1])


def _asf_paths(amc: Path) -> list[Path]:
    name = amc.name[:-3] if amc.name.lower().endswith(".gz") else amc.name
    parts = Path(name).stem.split("_")
    return [amc.with_name(f"{'_'.join(parts[:n])}.asf") for n in range(len(parts), 0, -1)]


def _motion(numbers: np.ndarray, frames: np.ndarray, asf: AsfFile, in_radians: bool, frame_rate: float) -> Motion:
    """The motion of a file's numbers (n_frames, n_channels), with each channel assigned by name."""
    names = (f"{bone}_{channel}" for bone, channels in asf.channels.items() for channel in channels)
    column = {name: i for i, name in enumerate(names)}
    angles = numbers[:, [column[name] for name in asf.skeleton.dof_names]]
    root_angles = numbers[:, [column[f"root_r{axis}"] for axis in asf.root_axes]]
    root_angles = root_angles + [asf.root_orientation["xyz".index(axis)] for axis in asf.root_axes]
    if not in_radians:
        angles, root_angles = np.radians(angles, out=angles), np.radians(root_angles)
    positions = np.tile(asf.root_position, (len(numbers), 1))
    for i, axis in enumerate("xyz"):
        if f"root_t{axis}" in column:
            positions[:, i] += numbers[:, column[f"root_t{axis}"]]
    return Motion(asf.skeleton, angles, frame_rate, asf.scale * positions, root_angles, asf.root_axes, frames)


def _read_rows(source: Source, asf: AsfFile, lines: list[Line], *, fill: bool, finite: bool) -> np.ndarray:
    """The numbers of all frames, (n_frames, n_channels), zero for bones that a frame does not mention if `fill`."""
    starts = [i for i, (_, text) in enumerate(lines) if text.strip().isdecimal()]
    if not starts or starts[0] > 0:
        line = lines[0][0] if lines else len(source.lines)
        raise source.error("expected the number of a frame, found none; not AMC, or cut short", line)
    columns_of, frames, texts = dict[tuple, np.ndarray](), list[np.ndarray](), list[str]()
    for expected, (start, stop) in enumerate(pairwise([*starts, len(lines)]), int(lines[0][1].strip()[:18])):
        line, number = lines[start]
        if not WHOLE.fullmatch(number.strip()) or int(number) != expected:
            raise source.error(f"expected frame {expected}, found frame {number.strip()[:40]}", line)
        frame = [text.split() for _, text in lines[start + 1 : stop]]
        form = tuple([words[0] for words in frame]), tuple(map(len, frame))
        if form not in columns_of:  # most files have one form
            columns_of[form] = _columns(source, asf, form, [line for line, _ in lines[start:stop]], fill)
        frames.append(columns_of[form])
        texts.append(" ".join([word for words in frame for word in words[1:]]))
    numbers = parse("\n".join(texts).encode())
    if numbers is None or (finite and not np.isfinite(numbers).all()):
        words_at = ((line, text.split()) for line, text in lines)
        numbers = np.array(
            [
                source.number(word, words[0], line, finite=finite, nan=not finite)  # which raises for one of them
                for line, words in words_at
                for word in words[1:]
            ]
        )
    columns, at = np.concatenate(frames), np.repeat(np.arange(len(frames)), [len(each) for each in frames])
    n_channels = sum(map(len, asf.channels.values()))
    wrong = (columns == n_channels) & np.isfinite(numbers) & (numbers != 0.0)
    if wrong.any():
        line, _ = lines[starts[at[wrong.argmax()]]]
        raise source.error("expected zeros of the bones without dofs in this frame; is it the right skeleton?", line)
    rows = np.zeros((len(frames), n_channels + 1))
    rows[at, columns] = numbers
    return rows[:, :-1]


def _columns(source: Source, asf: AsfFile, form: tuple, lines: list[int], fill: bool) -> np.ndarray:
    """The column of each number of a frame, by the first words of its lines and their lengths; the last if rigid."""
    channels = asf.channels
    first = dict(zip([*channels, ""], np.cumsum([0, *map(len, channels.values())]).tolist(), strict=True))
    columns, names = list[int](), form[0]
    for i, (name, n_words) in enumerate(zip(*form, strict=True)):
        n = n_words - 1
        is_rigid = name in asf.bones and name not in channels
        if name in names[:i] or not (is_rigid or (name in channels and n == len(channels[name]))):
            raise source.error(
                f"expected a bone of {asf.name} with its numbers, found {name[:40]!r} with {n}", lines[i + 1]
            )
        columns += [first[""]] * n if is_rigid else range(first[name], first[name] + n)
    absent = [name for name in channels if name not in names]
    if absent and not fill:
        raise source.error(f"expected {', '.join(absent[:5])} in the frame: missing='rest' takes zeros", lines[-1])
    return np.array(columns, dtype=int)
