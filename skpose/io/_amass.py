"""AMASS files: motions of the body models SMPL, SMPL-H and SMPL-X as .npz files.

N. Mahmood, N. Ghorbani, N. F. Troje, G. Pons-Moll, M. J. Black, "AMASS: archive of motion capture as surface shapes",
ICCV 2019, doi:10.1109/ICCV.2019.00554.
"""

from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.warnings import warn
from skpose.io._arguments import PathLike, Readable
from skpose.io._arrays import Archive
from skpose.io._conventions import Up, check_options, choose_rate, stand
from skpose.io._numbers import drop_not_finite
from skpose.io._smpl import BY_SIZE, HANDS, MODELS, mean_joints, shaped_joints
from skpose.io._source import Source, open_source
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._continuity import continuous_triples

ROOT_AXES = "ZYX"  # the heading first, as z is up; degenerate only where a person lies on the side
RATES = "mocap_framerate", "mocap_frame_rate"
# Parts of a pose and their widths, of files without `poses`, in its order.
PARTS = {"root_orient": 3, "pose_body": 63, "pose_jaw": 3, "pose_eye": 6, "pose_hand": 90}
FACE = "pose_jaw", "pose_eye"  # only in SMPL-X
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
    source = open_source(path, "an AMASS file (.npz)", binary=True)
    file, finite = Archive(source), on_nan == "raise"
    if "trans" not in file.keys:
        raise source.error(f"expected the key 'trans', zeros (n, 3) if it is not known, found {file.list_keys()}")
    trans = file.numbers("trans", (None, 3), finite=finite)
    name, poses = _poses(file, len(trans), finite)
    rate = _frame_rate(file, frame_rate)
    rows, frames = drop_not_finite(np.hstack([trans, poses]), np.arange(len(trans)), source)
    trans, poses = rows[:, :3], rows[:, 3:]
    if model is None:
        warn(
            "bones have the lengths of a person of mean height and proportions, as AMASS files have no skeleton: "
            "model= takes them from the file of an SMPL model and the betas of the motion"
        )
        joints = mean_joints(name)
    else:
        joints = shaped_joints(file, name, model)
    tree = MODELS[name]
    at_rest: dict[str | None, np.ndarray] = dict(zip(tree, joints, strict=True))
    root, *kept = [joint for joint in tree if hands or joint not in HANDS]
    bones = [
        Bone(joint, None if tree[joint] == root else tree[joint], at_rest[joint] - at_rest[tree[joint]], "rotvec")
        for joint in kept
    ]
    with source.format_errors():
        vectors = Rotation.from_rotvec(poses[:, :3]) if len(poses) else None
        motion = Motion(
            Skeleton(bones, offset_frame="parent"),
            poses[:, np.repeat([joint in kept for joint in tree], 3)],
            rate,
            trans + at_rest[root],
            np.zeros((0, 3)) if vectors is None else continuous_triples(ROOT_AXES, vectors),
            ROOT_AXES,
            frames,
            root_name=root,
        )
    speeds = np.linalg.norm(np.diff(trans, axis=0), axis=1) * rate
    if len(speeds) and np.median(speeds) > FASTEST and np.ptp(trans, axis=0).max() > FARTHEST:
        source.warn(f"trans moves by {np.median(speeds):.3g} m/s in the median frame: is it in metres?")
    return stand(motion, up, source, "z")


def _poses(file: Archive, n_frames: int, finite: bool) -> tuple[str, np.ndarray]:
    """The body model, by the width of its poses, and the rotation vectors (n_frames, 3 n_joints) of all joints."""
    if "poses" in file.keys:
        shapes = [(n_frames, 3 * size) for size in BY_SIZE]
        poses = file.numbers("poses", *shapes, finite=finite)
        return BY_SIZE[poses.shape[1] // 3], poses
    if not file.keys & set(PARTS):
        raise file.source.error(f"expected the key 'poses' of AMASS, found {file.list_keys()}")
    name = "SMPL-X" if file.keys & set(FACE) else "SMPL-H"
    parts = {key: width for key, width in PARTS.items() if name == "SMPL-X" or key not in FACE}
    arrays = [file.numbers(key, (n_frames, width), finite=finite) for key, width in parts.items()]
    return name, np.concatenate(arrays, axis=1)


def _frame_rate(file: Archive, given: float | None) -> float:
    """The frames per second, Hz, which the two generations of files have under different keys."""
    key = next((key for key in RATES if key in file.keys), "")
    rate = float(file.numbers(key, (), (1,), finite=given is None).item()) if key else np.nan
    if given is None and not (rate > 0.0 and np.isfinite(1.0 / rate)):
        found = f"{key} of {rate:g}" if key else file.list_keys()
        raise file.source.error(f"expected {RATES[0]}, a positive number, found {found}: pass frame_rate=")
    return choose_rate(file.source, given, rate, key)


def is_amass(source: Source) -> bool:
    """Whether a file is an archive: an .npz file with other keys than those of skpose is read as one of AMASS."""
    return source.kind == "zip"
