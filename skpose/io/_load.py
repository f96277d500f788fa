"""Motions of any format, which is recognised by the content of the file."""

from typing import Any

from skpose.io._arguments import Readable
from skpose.io._formats import EXPECTED, FORMATS, format_of
from skpose.io._source import Source
from skpose.skeleton import Motion

DECISIVE = "root", "scale"  # options without which the result is another


def load_motion(path: Readable, **options: Any) -> Motion:
    """Read a motion from a BVH, AMC or AMASS file, or from one that `save_npz` wrote.

    The format is recognised by the content of the file, not by its name.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    **options
        Options of the loader of the format: `load_bvh`, `load_amc` or `load_amass`. Those that only another format has
        are ignored, so that files of several formats can be read in a loop; but `root` is only for BVH files, and
        `scale` is not for files in metres (AMASS and those of `save_npz`). The most common are

        - `scale`, metres per unit of length, such as 0.01 for a BVH file in centimetres;
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
    save_bvh, save_npz : Write a motion.
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
    source = Source(path, EXPECTED, binary=True)
    found = format_of(source)
    if found.content != "motion":
        raise source.error(f"this is a {found.name} file without a motion: {found.load.__name__} reads it")
    given = {name: value for name, value in options.items() if value is not None}
    for name in DECISIVE:
        if name in given and name not in found.options and (name, given[name]) != ("scale", 1.0):
            raise ValueError(f"{name}={given[name]!r} is not an option of {found.name} files, as {source.name} is")
    motion: Motion = found.load(source, **{name: given[name] for name in given if name in found.options})
    return motion
