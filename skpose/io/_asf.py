"""Readers of Acclaim skeleton files (ASF), the format of the CMU database."""

from skpose._validation.options import check_positive
from skpose.io._acclaim import Acclaim
from skpose.io._arguments import Readable
from skpose.io._asf_parser import parse_asf
from skpose.io._source import Source
from skpose.skeleton import Skeleton


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
    >>> motions = [load_amc(f"02_{trial:02}.amc", asf) for trial in range(1, 11)]  # doctest: +SKIP
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
        return self._content.name

    @property
    def scale(self) -> float:
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
