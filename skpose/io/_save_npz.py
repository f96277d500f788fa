"""Motions and keypoints as .npz files of this library: numpy's arrays by name, with all that they rest on."""

from typing import Any

import numpy as np

from skpose._utils.files import new_file
from skpose.io._conventions import Up, check_options, choose_rate, stand
from skpose.io._source import Archive, PathLike, Readable, Source, open_source
from skpose.keypoints import Keypoints
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._bone import HINGE, SLIDE

VERSION = "skpose_motion"  # the key that only motions of this library have, with the version of the format
LATEST = 2
LARGEST = 2**53  # of frame numbers, which are read as float64


def save_npz(path: PathLike, content: Motion | Keypoints) -> None:
    """Write a motion or keypoints as an .npz file, which loses nothing.

    Parameters
    ----------
    path : str or path-like
        The file, which must not exist yet. It is written whole or not at all.
    content : Motion or Keypoints
        What to write.

    Raises
    ------
    TypeError
        If it is neither a motion nor keypoints.
    ValueError
        For frame numbers from 2⁵³ on, which would be others where the file is read.
    OSError
        If the file exists, or cannot be written.

    See Also
    --------
    load_motion : Read the motion again.
    load_keypoints : Read the keypoints again.
    save_bvh : Write a motion for other programs.
    save_csv : Write the angles or the positions as a table.

    Notes
    -----
    ``numpy.load(path)["angles"]`` and so on are the arrays of a motion; nothing is pickled:

    =================================== ================================================================
    ``angles``, ``dof_names``           (n_frames, n_dofs), rad; one name for each column
    ``frame_rate``, ``frame_numbers``   Hz; (n_frames,), whose times are the numbers over the rate
    ``up``                              the axis of the world that points up: x, y or z
    ``root_positions``, ``root_angles`` (n_frames, 3), m; (n_frames, k), rad
    ``root_axes``, ``root_name``        texts, see `Motion`
    ``seen``                            (n_frames, n_joints), 1 or 0, see `Motion`; (0, 0) where it is None
    ``joint_names``, ``joint_parents``  (n_joints,); an empty text is the root
    ``joint_offsets``, ``joint_dofs``   (n_joints, 3), m; (n_joints,) texts, see `Bone`
    ``joint_axes``                      (n_joints, 3), of hinges; NaN elsewhere
    ``rest_rotations``, ``limits``      (n_joints, 3, 3); (n_dofs, 2), rad; NaN where a bone has none
    ``weights``                         (n_joints,); NaN where a bone has none
    ``offset_frame``                    own or parent, see `Skeleton`
    ``skpose_motion``                   the version of the format, 2
    =================================== ================================================================

    Keypoints have the keys that `load_keypoints` lists, and ``up``.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import numpy as np
    >>> from skpose.datasets import make_gait
    >>> from skpose.io import load_motion, save_npz
    >>> walk = make_gait(1, 1, random_state=0)[0]
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "walk.npz")
    ...     save_npz(path, walk)
    ...     again = load_motion(path)
    >>> again.skeleton == walk.skeleton, np.array_equal(again.angles, walk.angles)
    (True, True)
    """
    if isinstance(content, Motion):
        if len(content) and np.abs(content.frame_numbers).max() >= LARGEST:
            raise ValueError(f"frame_numbers must be less than 2**53, got {content.frame_numbers.max()}")
        arrays = _of_motion(content)
    elif isinstance(content, Keypoints):
        names = ("positions", "confidences", "names", "frame_rate", "up")
        arrays = {name: np.asarray(getattr(content, name)) for name in names}
    else:
        raise TypeError(f"content must be a skpose.Motion or skpose.Keypoints, got {type(content).__name__}")
    with new_file(path) as new, new.open("wb") as file:  # to a path numpy adds .npz where it is missing
        np.savez(file, **arrays)


def _of_motion(motion: Motion) -> dict[str, Any]:
    """The arrays of a motion by their keys."""
    bones = motion.skeleton.bones
    nowhere = np.full((3, 3), np.nan)
    limits = [np.full((bone.n_dofs, 2), np.nan) if bone.limits is None else bone.limits for bone in bones]
    names = "angles", "frame_rate", "frame_numbers", "up", "root_positions", "root_angles", "root_axes", "root_name"
    return {
        VERSION: np.asarray(LATEST),
        **{name: np.asarray(getattr(motion, name)) for name in names},
        "seen": np.zeros((0, 0), np.uint8) if motion.seen is None else motion.seen.astype(np.uint8),
        "dof_names": np.array(motion.skeleton.dof_names),
        "joint_names": np.array(motion.skeleton.joint_names),
        "joint_parents": np.array([bone.parent or "" for bone in bones]),
        "joint_offsets": motion.skeleton.offsets,
        "joint_dofs": np.array([bone.dofs for bone in bones]),
        "joint_axes": np.array([np.full(3, np.nan) if bone.axis is None else bone.axis for bone in bones]),
        "rest_rotations": np.array([nowhere if b.rest_rotation is None else b.rest_rotation for b in bones]),
        "limits": np.concatenate([np.reshape(pairs, (-1, 2)) for pairs in limits]),
        "weights": np.array([np.nan if bone.weight is None else bone.weight for bone in bones]),
        "offset_frame": np.asarray(motion.skeleton.offset_frame),
    }


def load_npz(
    path: Readable | Source, *, frame_rate: float | None = None, on_nan: str = "raise", up: Up | None = None
) -> Motion:
    """Read the motion of a file that `save_npz` wrote."""
    check_options(frame_rate=frame_rate, on_nan=on_nan, up=up)
    source = open_source(path, "a file of save_npz", binary=True)
    file = Archive(source)
    version = file.numbers(VERSION, ()).item()
    if version != LATEST:
        raise source.error(f"expected version {LATEST} of the format, found {version:g}")
    with source.format_errors():
        skeleton = _skeleton(file)
        angles = file.numbers("angles", (None, skeleton.n_dofs))
        n, axes = len(angles), _text(file, "root_axes")
        numbers = file.numbers("frame_numbers", (n,))
        if (numbers % 1.0).any() or (np.abs(numbers) >= LARGEST).any():
            raise source.error("frame_numbers: expected whole numbers")
        seen = file.numbers("seen", (n, skeleton.n_joints), (0, 0))
        motion = Motion(
            skeleton,
            angles,
            choose_rate(source, frame_rate, file.numbers("frame_rate", ()).item(), "frame_rate"),
            file.numbers("root_positions", (n, 3)),
            file.numbers("root_angles", (n, None)),
            axes,
            numbers.astype(np.int64),
            _text(file, "up"),
            root_name=_text(file, "root_name"),
            seen=seen > 0.0 if seen.shape == (n, skeleton.n_joints) else None,
        )
    return motion if up is None else stand(motion, up, source)


def _skeleton(file: Archive) -> Skeleton:
    names, dof_names = file.texts("joint_names", (None,)), file.texts("dof_names", (None,))
    n = len(names)
    parents, dofs = file.texts("joint_parents", (n,)), file.texts("joint_dofs", (n,))
    offsets = file.numbers("joint_offsets", (n, 3))
    axes = file.numbers("joint_axes", (n, 3), finite=False)
    rest = file.numbers("rest_rotations", (n, 3, 3), finite=False)
    weights = file.numbers("weights", (n,), finite=False)
    limits = file.numbers("limits", (len(dof_names), 2), finite=False)
    bones, column = [], 0
    for i, name in enumerate(names):
        bone = Bone(name, parents[i] or None, offsets[i], dofs[i])
        pairs, own_names = limits[column : column + bone.n_dofs], dof_names[column : column + bone.n_dofs]
        column += bone.n_dofs
        bones.append(
            bone._replace(
                rest_rotation=None if np.isnan(rest[i]).all() else rest[i],
                limits=None if np.isnan(pairs).all() else pairs,
                weight=None if np.isnan(weights[i]) else weights[i],
                axis=None if np.isnan(axes[i]).all() else axes[i],
                dof_name=own_names[0] if bone.dofs in (HINGE, SLIDE) and own_names else None,
            )
        )
    skeleton = Skeleton(bones, _text(file, "offset_frame"))
    if list(skeleton.dof_names) != dof_names:
        raise file.source.error("dof_names: expected the names of the dofs of the joints, in their order")
    return skeleton


def _text(file: Archive, key: str) -> Any:
    """A text, which Motion and Skeleton check."""
    return file.texts(key, ())[0]
