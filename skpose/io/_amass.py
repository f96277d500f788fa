"""Motions of the body models SMPL, SMPL-H and SMPL-X, as in AMASS and as programs find them in videos.

N. Mahmood, N. Ghorbani, N. F. Troje, G. Pons-Moll, M. J. Black, "AMASS: archive of motion capture as surface shapes",
ICCV 2019, doi:10.1109/ICCV.2019.00554.
"""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.warnings import warn
from skpose.io._arguments import PathLike, Readable
from skpose.io._arrays import Archive
from skpose.io._conventions import Up, check_options, choose_rate, stand
from skpose.io._numbers import drop_not_finite
from skpose.io._smpl import HANDS, Tree, mean_joints, shaped_joints
from skpose.io._smpl_parameters import BETAS, RATES, find_key, open_arrays, read_parameters
from skpose.io._source import open_source
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._continuity import continuous_triples
from skpose.skeleton._upright import describe_up, find_up

# By the axis that points up: the heading first; degenerate only where a person lies on the side.
ROOT_AXES = {"x": "XZY", "y": "YZX", "z": "ZYX"}
FASTEST, FARTHEST = 15.0, 30.0  # m/s, which no person reaches, and m


def load_amass(
    path: Readable,
    *,
    frame_rate: float | None = None,
    model: PathLike | None = None,
    hands: bool = True,
    on_nan: Literal["raise", "drop"] = "raise",
    up: Up | None = None,
) -> Motion:
    """Read a motion of AMASS, or any other of SMPL, SMPL-H or SMPL-X in its format, from an .npz file.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one.
    frame_rate : float, default=None
        Frames per second, Hz. By default the file's own; a number replaces it, with a warning if the two differ by more
        than 1 %.
    model : str or path-like, default=None
        The file of the body model (.npz), from which the lengths of the bones follow with the `betas` of the motion;
        "{gender}" in it becomes female, male or neutral, as the motion states. By default a person of mean height and
        proportions, with a warning.
    hands : bool, default=True
        Whether to read the joints beyond the wrists. Without them motions of SMPL and of SMPL-H have one skeleton.
    on_nan : {"raise", "drop"}, default="raise"
        Refuse a file with NaN or infinite numbers in the poses or `trans`, or leave these frames out. The other frames
        keep their numbers and times, see `Motion.frame_numbers`.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The axis of the file's world that points up, as in `load_bvh`. By default z.

    Returns
    -------
    Motion
        Motion whose skeleton has a ball joint for every joint of the model except the pelvis, which is the root. Its
        columns are the file's numbers, rotation vectors in rad, in the file's order.

    Raises
    ------
    MocapFormatError
        If the file, or the model's, is damaged or of another kind; with its name and the key.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If no model is given, the model has fewer directions of shape than the file has `betas`, frames are left out,
        the frame rate is replaced, or `trans` is faster than people, as in centimetres.

    See Also
    --------
    load_motion : Read a motion of any format.
    skpose.datasets.humanoid : The proportions without a model, as a skeleton of its own.

    Notes
    -----
    The joints at rest are J = J_regressor · (v_template + shapedirs · betas), all from the model except `betas`. Bones
    are the differences of J, and the root moves along `trans` + J of the pelvis. The models are not free and not part
    of this library: https://smpl.is.tue.mpg.de, https://mano.is.tue.mpg.de and https://smpl-x.is.tue.mpg.de have them.
    Without one, J of the pelvis is unknown as well, so that positions of the root are shifted by one vector (in the
    models by 0.3 m).

    The root's rotation vectors become angles about the axes "ZYX": the heading, then the lean to a side, then forward,
    where 90° is upright, since a model's own y axis points up.

    Nothing is unpickled. Models are read once and kept while their file does not change.

    References
    ----------
    .. [1] N. Mahmood, N. Ghorbani, N. F. Troje, G. Pons-Moll, M. J. Black, "AMASS: archive of motion capture as surface
       shapes", ICCV 2019, :doi:`10.1109/ICCV.2019.00554`.
    .. [2] M. Loper, N. Mahmood, J. Romero, G. Pons-Moll, M. J. Black, "SMPL: a skinned multi-person linear model", ACM
       Trans. Graphics 34, 2015, :doi:`10.1145/2816795.2818013`.

    Examples
    --------
    >>> from skpose.io import load_amass
    >>> load_amass("ACCAD/Female1Walking_c3d/B3_-_walk1_poses.npz", model="smplh/{gender}/model.npz")  # doctest: +SKIP
    Motion(415 frames at 120 Hz, 3.5 s, z up, Skeleton(n_joints=51, n_dofs=153))
    """
    check_options(frame_rate=frame_rate, on_nan=on_nan, up=up)
    source = open_source(path, "a file of SMPL parameters", binary=True)
    file = open_arrays(source)
    with source.format_errors():
        found = read_parameters(file, on_nan == "raise")
    rate, tree = _frame_rate(file, frame_rate), found.tree
    rows, frames = drop_not_finite(np.hstack([found.position, found.rotations]), np.arange(len(found.position)), source)
    position, poses, joints = rows[:, :3], rows[:, 3:], found.joints
    if model is not None:
        joints = shaped_joints(file, len(tree), model, find_key(file, BETAS) or BETAS[0])
    elif joints is None:
        warn(
            "bones have the lengths of a person of mean height and proportions, as AMASS files have no skeleton: "
            "model= takes them from the file of an SMPL model and the betas of the motion"
        )
        joints = mean_joints(tree)
    skeleton = smpl_skeleton(tree, joints, hands)
    turns = Rotation.from_rotvec(poses[:, :3].reshape(-1, 3)) if len(poses) else None
    shift = joints[0] if turns is None or not found.is_about_origin else turns.apply(joints[0])
    kept = np.isin([*tree], ["pelvis", *skeleton.joint_names])
    with source.format_errors():
        motion = Motion(
            skeleton,
            poses[:, np.repeat(kept, 3)][:, 3:],
            rate,
            position + shift,
            np.zeros((0, 3)) if turns is None else turns.as_euler("ZYX"),
            "ZYX",
            frames,
            root_name="pelvis",
        )
    speeds = np.linalg.norm(np.diff(position, axis=0), axis=1) * rate
    if len(speeds) and np.median(speeds) > FASTEST and np.ptp(position, axis=0).max() > FARTHEST:
        key = found.position_key
        source.warn(f"{key} moves by {np.median(speeds):.3g} m/s in the median frame: is it in metres?")
    axis: Any = up
    if up is None:
        usual = "z" if found.position_key == "trans" else "y"  # as in AMASS
        axis = find_up(motion, usual)
        if axis != usual == "z":
            source.warn(f"{axis} is taken as up, not z as in AMASS, as {describe_up(axis)}: up='z' keeps that")
    if turns is not None:
        axes = ROOT_AXES[axis[-1]]
        motion = replace(motion, root_angles=continuous_triples(axes, turns), root_axes=axes)
    return stand(motion, axis, source)


def smpl_skeleton(tree: Tree, joints: np.ndarray, hands: bool = True) -> Skeleton:
    """The skeleton of a model with its joints (n_joints, 3) at rest; the pelvis is the root."""
    at_rest: dict[Any, np.ndarray] = dict(zip(tree, joints, strict=True))
    bones = [
        Bone(joint, None if parent == "pelvis" else parent, at_rest[joint] - at_rest[parent], "rotvec")
        for joint, parent in tree.items()
        if parent and (hands or joint not in HANDS)
    ]
    return Skeleton(bones, offset_frame="parent")


def _frame_rate(file: Archive, given: float | None) -> float:
    """The frames per second, Hz, which files have under different keys."""
    key = find_key(file, RATES)
    rate = float(file.numbers(key, (), (1,), finite=given is None).item()) if key else np.nan
    if given is None and not (rate > 0.0 and np.isfinite(1.0 / rate)):
        found = f"{key} of {rate:g}" if key else file.list_keys()
        raise file.source.error(f"expected {RATES[0]}, a positive number, found {found}: pass frame_rate=")
    return choose_rate(file.source, given, rate, key)
