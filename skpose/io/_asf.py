"""Reader of Acclaim skeleton files (ASF), the format of the CMU database: sections, statements, the checks of both."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._validation.options import check_positive
from skpose.io._acclaim import CHANNELS, ROTATIONS, Acclaim, AcclaimBone, AcclaimRoot
from skpose.io._arguments import Readable
from skpose.io._source import Source
from skpose.io._words import NUMBER, Token
from skpose.skeleton import Skeleton

INCH = 0.0254  # m; the unit of length of the format, divided by the file's `length`

Statements = list[list[Token]]


class AsfFile:
    """An Acclaim ASF file that is read once and serves any number of AMC files.

    Pass it as `asf` to `load_amc` and `load_motion` instead of a path. All motions then share one skeleton, which is
    built once.

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

    Raises
    ------
    MocapFormatError
        If the file is not a whole ASF file; with its name, the line and the column.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If the skeleton has not the size of a person, see `load_asf`.

    See Also
    --------
    load_asf : Read the skeleton alone.

    Examples
    --------
    >>> from skpose.io import AsfFile, load_amc
    >>> asf = AsfFile("02.asf")  # doctest: +SKIP
    >>> motions = [load_amc(f"02_{trial:02}.amc", asf, frame_rate=120) for trial in range(1, 11)]  # doctest: +SKIP
    """

    def __init__(self, path: Readable, *, scale: float | None = None):
        if scale is not None:
            check_positive("scale", scale)
        with Source(path, "an ASF file") as source:
            self._content = parse_asf(source, scale)
            with source.format_errors():
                self.skeleton: Skeleton = self._content.skeleton
                source.warn_of_size(self.skeleton, self._content.scale)

    @property
    def name(self) -> str:
        """The file's name, without its folder."""
        return self._content.name

    @property
    def scale(self) -> float:
        """Metres per unit of length."""
        return self._content.scale

    def __repr__(self) -> str:
        return f"AsfFile({self.name!r}, {self.skeleton})"


def content_of(asf: Readable | AsfFile, scale: float | None) -> Acclaim:
    """Return the content of an ASF file, which is read unless it is one that has been read."""
    if not isinstance(asf, AsfFile):
        asf = AsfFile(asf, scale=scale)
    elif scale not in (None, asf.scale):
        raise ValueError(f"scale must be that of {asf!r}, {asf.scale}, or None, got {scale!r}; pass scale= to AsfFile")
    return asf._content


def load_asf(path: Readable, *, scale: float | None = None) -> Skeleton:
    """Read a skeleton from an Acclaim ASF file.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    scale : float, default=None
        Metres per unit of length. None follows the file's ``:units length``, as for CMU: one unit is 1/length inch,
        0.0564 m at 0.45. 1.0 leaves the file's numbers as they are.

    Returns
    -------
    Skeleton
        Skeleton with one joint at the far end of every bone, named after it, and the file's limits. Bones without
        dofs are rigid.

    Raises
    ------
    MocapFormatError
        If the file is not a whole ASF file; with its name, the line and the column.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If the skeleton has not the size of a person, 0.3 to 5 m from end to end at angle zero: the message names the
        `scale` that would give it.

    See Also
    --------
    AsfFile : Read an ASF file once for several AMC files.
    load_amc : Read a motion of the skeleton.

    Notes
    -----
    Euler angles are extrinsic in the order of each bone's `axis`, unlike those of BVH. The root's own position and
    orientation are not part of a skeleton; `load_amc` adds them to the root's channels.

    Examples
    --------
    >>> from skpose.io import load_asf
    >>> load_asf("02.asf")  # doctest: +SKIP
    Skeleton(n_joints=30, n_dofs=56)
    """
    return AsfFile(path, scale=scale).skeleton


def parse_asf(source: Source, scale: float | None) -> Acclaim:
    """Return the content of an ASF file; a scale, m per unit of length, replaces the file's."""
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
            raise source.error(f"bone {name!r} does not appear under :hierarchy", bone.begin)
    return Acclaim(Path(source.name).name, bones, parents, scale, radians, root)


def _sections(source: Source) -> dict[str, Statements]:
    """Return the file's statements by the keyword of their section."""
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


def _read_root(section: Statements, source: Source) -> AcclaimRoot:
    root = AcclaimRoot()
    for tokens in section:
        key = tokens[0].lower()
        if key == "order":
            root.channels = _some_of(CHANNELS, tokens, source, "order of the root")
        elif key == "axis":
            root.order = _axis_order(tokens, source, "axis of the root")
        elif key in ("position", "orientation"):
            setattr(root, key, np.array(_numbers(3, tokens, source, f"{key} of the root")))
    return root


def _read_bones(section: Statements, radians: bool, source: Source) -> dict[str, AcclaimBone]:
    bones: dict[str, AcclaimBone] = {}
    begin: Token | None = None  # of the block that is open
    given: dict[str, Any] = {}  # by the statements of that block
    key: str | None = None
    for tokens in section:
        word = tokens[0].lower()
        if word == "begin":
            if begin is not None:
                raise source.error(f"bone {_name(given)}, which begins in line {begin.line}, has no end", tokens[0])
            begin, given, key = tokens[0], {}, None
        elif begin is None:
            raise source.error(f"expected begin, found {str(tokens[0][:40])!r}", tokens[0])
        elif word == "end":
            bone = _bone(begin, given, tokens[0], source)
            if bone.name in bones:
                raise source.error(f"bone {bone.name!r} is defined twice", begin)
            bones[bone.name], begin = bone, None
        elif key == "limits" and (NUMBER.fullmatch(word) or not word[0].isalpha()):  # one pair a line, or all in one
            _read_key("limits", given, [tokens[0], *tokens], radians, source)
        else:
            key = tokens[0].lower()
            _read_key(key, given, tokens, radians, source)
    if begin is not None:
        raise source.error(f"bone {_name(given)} begins here and has no end; is the file cut short?", begin)
    if not bones:
        raise source.error("there are no bones under :bonedata")
    return bones


def _name(given: dict[str, Any]) -> str:
    """Return the quoted name of the bone of a block, as far as it is read."""
    return repr(given.get("name", ""))


def _read_key(key: str, given: dict[str, Any], tokens: list[Token], radians: bool, source: Source) -> None:
    """Add what one statement gives; ignore those that no pose needs, such as id and bodymass."""
    what = f"{key} of bone {_name(given)}"
    if key == "name":
        if len(tokens) != 2:
            raise source.error(f"name of a bone: expected one word, found {' '.join(tokens[1:])[:40]!r}", tokens[-1])
        given["name"] = str(tokens[1])
    elif key == "direction":
        given["direction"] = np.array(_numbers(3, tokens, source, what))
    elif key == "length":
        (given["length"],) = _numbers(1, tokens, source, what)
    elif key == "axis":
        order = _axis_order(tokens, source, what)
        angles = dict(zip("xyz", _numbers(3, tokens[:-1], source, what), strict=True))
        given["order"] = order
        given["axis"] = Rotation.from_euler(order, [angles[axis] for axis in order], degrees=not radians)
    elif key == "dof":
        given["dofs"] = _some_of(ROTATIONS, tokens, source, what)
    elif key == "limits":
        numbers = [source.number(token, what, finite=False) for token in tokens[1:]]
        given["limits"] = given.get("limits", []) + numbers


def _bone(begin: Token, given: dict[str, Any], end: Token, source: Source) -> AcclaimBone:
    """Return the bone of a block, checked."""
    for key in ("name", "direction", "length"):
        if key not in given:
            raise source.error(f"bone {_name(given)}, which begins in line {begin.line}, has no {key}", end)
    bone = AcclaimBone(begin, **given)
    if bone.name == "root":
        raise source.error("a bone is named 'root', which is the name of the root; give it another name", begin)
    with source.format_errors():
        norm = np.linalg.norm(bone.direction)
    if not np.isfinite(norm) or (norm == 0 and bone.length != 0):
        raise source.error(f"bone {bone.name!r} has a length but no direction", begin)
    bone.direction = bone.direction / (norm or 1.0)  # printed to six digits, so its length is not exactly 1
    if bone.limits and len(bone.limits) != 2 * len(bone.dofs):
        raise source.error(
            f"bone {bone.name!r}: expected a pair of limits for each of its {len(bone.dofs)} dofs, found "
            f"{len(bone.limits)} numbers",
            end,
        )
    return bone


def _numbers(n: int, tokens: list[Token], source: Source, what: str, positive: bool = False) -> list[float]:
    """Return the n numbers after a keyword."""
    if len(tokens) != n + 1:
        raise source.error(f"{what}: expected {n} numbers, found {len(tokens) - 1}", tokens[-1])
    return [(source.positive if positive else source.number)(token, what) for token in tokens[1:]]


def _some_of(choices: tuple[str, ...], tokens: list[Token], source: Source, what: str) -> list[str]:
    """Return the words after a keyword, each one of the choices and none twice."""
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


def _read_hierarchy(section: Statements, bones: dict[str, AcclaimBone], source: Source) -> dict[str, str | None]:
    """Return the parent of every bone, None for the root."""
    parents: dict[str, str | None] = {}
    for parent, *children in section:
        if not children and parent.lower() in ("begin", "end"):
            continue
        if parent not in bones and parent != "root":
            child = str(children[0]) if children else ""
            raise source.error(f"bone {child!r} is a child of {str(parent)!r}, which the file does not define", parent)
        for child in children:
            if child not in bones:
                raise source.error(
                    f"bone {str(child)!r} is a child of {str(parent)!r}, but the file does not define it", child
                )
            if child in parents:
                raise source.error(f"bone {str(child)!r} is a child of {parents[child] or 'root'!r} already", child)
            parents[str(child)] = None if parent == "root" else str(parent)
    return parents
