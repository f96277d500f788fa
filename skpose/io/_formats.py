"""The formats of files: one entry for each, which `load_motion`, the command line and the documentation use.

To add a format, write a module with its loader and a function that recognises it by its content, and add an entry here.
The options of a format are the keyword arguments of its loader. Formats that are known and not read are in `_source`.
"""

import inspect
from collections.abc import Callable
from typing import Any, Literal, NamedTuple

from skpose.io._acclaim import KEYWORDS, is_amc, load_amc, load_asf
from skpose.io._amass import is_smpl, load_amass
from skpose.io._bvh import load_bvh
from skpose.io._c3d import load_c3d
from skpose.io._keypoints import TEXTS, is_array, load_keypoints
from skpose.io._keypoints_json import is_json
from skpose.io._save_npz import VERSION, load_npz
from skpose.io._source import Archive, Readable, Source, open_source
from skpose.io._tables import load_trc
from skpose.skeleton import Motion

DECISIVE = "root", "scale"  # options without which the result is another
EXPECTED = "a BVH, AMC, ASF, SMPL, TRC or C3D file, or keypoints as JSON, CSV or arrays"


class Format(NamedTuple):
    """A format of files.

    Attributes
    ----------
    name : str
        A short name, such as "BVH".
    content : {"motion", "skeleton", "points"}
        What the loader returns: a Motion, a Skeleton or Keypoints.
    suffixes : tuple of str
        The suffixes of its files, in lower case; ".gz" may follow.
    recognizes : callable
        Whether a `Source` has this format, by its content.
    load : callable
        The loader, of a path, an open file or a `Source`.
    """

    name: str
    content: Literal["motion", "skeleton", "points"]
    suffixes: tuple[str, ...]
    recognizes: Callable[[Source], bool]
    load: Callable[..., Any]

    @property
    def options(self) -> tuple[str, ...]:
        """The options of the loader: its keyword arguments."""
        return tuple(inspect.signature(self.load).parameters)[1:]


# The first that recognises a file is its format.
FORMATS = (
    Format("BVH", "motion", (".bvh",), lambda source: source.first_word == "hierarchy", load_bvh),
    Format("ASF", "skeleton", (".asf",), lambda source: source.first_word in KEYWORDS, load_asf),
    Format(
        "NPZ", "motion", (".npz",), lambda source: source.kind == "zip" and VERSION in Archive(source).keys, load_npz
    ),
    Format("TRC", "points", (".trc",), lambda source: source.first_word.startswith("pathfiletype"), load_trc),
    Format("C3D", "points", (".c3d",), lambda source: source.kind == "C3D", load_c3d),
    Format("arrays", "points", (".npz", ".npy"), is_array, load_keypoints),
    Format("SMPL", "motion", (".npz", ".npy", ".json"), is_smpl, load_amass),
    Format("JSON", "points", (".json",), is_json, load_keypoints),
    *(Format(name, "points", suffixes, recognizes, load_keypoints) for name, suffixes, recognizes, _ in TEXTS),
    Format("AMC", "motion", (".amc",), is_amc, load_amc),
)


def format_of(path: Readable | Source) -> Format:
    """The format of a file, recognised by its content.

    Raises
    ------
    MocapFormatError
        If the file has none of the formats.
    OSError
        If it cannot be read.
    """
    source = open_source(path, EXPECTED, binary=True)
    for one in FORMATS:
        if one.recognizes(source):
            return one
    raise source.error(f"expected {EXPECTED}, found {source.describe()}")


def load_motion(path: Readable, **options: Any) -> Motion:
    """Read a motion from a BVH, AMC or SMPL file, or from one that `save_npz` wrote.

    The format is recognised by the content of the file, not by its name.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not. Or a folder with a JSON file of SMPL for each frame.
    **options
        Options of the loader of the format: `load_bvh`, `load_amc` or `load_amass`. Those that only another format has
        are ignored, so that files of several formats can be read in a loop; but `root` is only for BVH files, and
        `scale` is not for files in metres (SMPL and those of `save_npz`). The most common are

        - `scale`, metres per unit of length, such as 0.01 for a BVH file in centimetres, or "auto";
        - `frame_rate` in Hz, which AMC files do not state;
        - `asf`, the skeleton of an AMC file, by default in its folder: walk.asf for walk.amc, or 02.asf for 02_01.amc;
        - `up`, the axis of the file's world that points up: "x", "y", "z", "-x", "-y" or "-z";
        - `on_nan="drop"`, which leaves out frames with NaN or infinite numbers.

    Returns
    -------
    Motion
        Motion with angles in rad and lengths in m.

    Raises
    ------
    MocapFormatError
        If the file is none of these, or damaged; with its name, and the line or the key.
    OSError
        If it cannot be read, or the skeleton of an AMC file is not found.
    TypeError
        If no format has an option.
    ValueError
        If an option has no meaning for the format.

    See Also
    --------
    save_bvh, save_npz, save_smpl : Write a motion.
    skpose.datasets.load_motions : Read a folder.
    load_trc, load_c3d, load_keypoints : Read positions of markers and keypoints.

    Examples
    --------
    >>> from skpose.io import load_motion
    >>> load_motion("dance.bvh.gz", scale=0.01)  # doctest: +SKIP
    Motion(1200 frames at 60 Hz, 20.0 s, y up, Skeleton(n_joints=52, n_dofs=114))
    >>> load_motion("cmu/subjects/02/02_01.amc", frame_rate=120)  # doctest: +SKIP
    Motion(343 frames at 120 Hz, 2.9 s, y up, Skeleton(n_joints=30, n_dofs=56))
    """
    known = {option for one in FORMATS if one.content == "motion" for option in one.options}
    if unknown := options.keys() - known:
        raise TypeError(
            f"load_motion has no option {sorted(unknown)[0]!r}: expected some of {', '.join(sorted(known))}"
        )
    source = open_source(path, EXPECTED, binary=True)
    found = format_of(source)
    if found.content != "motion":
        raise source.error(f"expected a motion, found {found.name}: {found.load.__name__} reads it")
    given = {name: value for name, value in options.items() if value is not None}
    if found.load is not load_bvh and given.get("scale") == "auto":  # other formats have a unit
        del given["scale"]
    for name in DECISIVE:
        if name in given and name not in found.options and given[name] not in (1.0, "auto"):
            raise ValueError(f"{name}={given[name]!r} is not an option of {found.name} files, as {source.name} is")
    motion: Motion = found.load(source, **{name: given[name] for name in given if name in found.options})
    return motion
