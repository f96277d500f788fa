"""The alignment of two motions: which frames correspond, and where the joints differ."""

from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Literal, NamedTuple, get_args

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._compiled.warping.paths import Paths, accumulate, path_to
from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_choice
from skpose.kinematics import forward_kinematics
from skpose.kinematics._anatomy import joint_places, rotation_places
from skpose.metrics import Metric
from skpose.metrics._matrix import DistanceMatrix, warn_of_unconverged
from skpose.metrics._registry import METRIC_CONSTRAINTS, resolve, warn_of_no_skeleton
from skpose.motions._distances import check_alignment
from skpose.motions._inputs import check_single_motions
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._bone import with_columns
from skpose.skeleton._root import has_root_joint
from skpose.skeleton._rotations import rotations_of

Quantity = Literal["distance", "rotation"]


class JointDifference(NamedTuple):
    """The difference of one joint in two aligned motions, from `Alignment.joint_differences`.

    Attributes
    ----------
    joint : str
        Name of the joint in the skeleton.
    place : str
        Name for readers: for people the place, with the joint's name if that differs, such as "left knee (lfemur)". For
        rotations it is the place of the joint that turns.
    largest : float
        The largest difference along the path, m or rad.
    mean : float
        The mean of the differences along the path, m or rad.
    frame_a, frame_b : int
        Frames of the two motions where the difference is largest.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.motions import align_motions
    >>> alignment = align_motions([[0.0], [1.0]], [[0.0], [1.0]], skeleton=Skeleton.chain(1))
    >>> alignment.joint_differences()
    [JointDifference(joint='joint_1', place='joint_1', largest=0.0, mean=0.0, frame_a=0, frame_b=0)]
    """

    joint: str
    place: str
    largest: float
    mean: float
    frame_a: int
    frame_b: int


@dataclass(frozen=True, eq=False, repr=False)
class Alignment:
    """The path that aligns two motions, and the difference of each joint along it, from `align_motions`.

    Attributes
    ----------
    path : ndarray of shape (n_pairs, 2) of ints
        Pairs of frames (i, j) of the two motions, in order; no frame in between is left out.
    distance : float
        The distance of `motion_distances`, m, or rad for "angle".
    distances : ndarray of shape (n_pairs,)
        Distance between the poses of each pair, m, or rad for "angle".
    joint_distances : ndarray of shape (n_pairs, n_joints) or None
        Distance between the positions of each joint relative to the root, m, in the axes of the world without the
        heading: a root that is tilted does not move the feet. Without the weights of the joints. The columns are
        ``skeleton.joint_names``. None without a skeleton.
    joint_rotations : ndarray of shape (n_pairs, n_joints) or None
        Angle between the rotations of each joint relative to its parent, rad, at most π; zero for joints without dofs.
        None without a skeleton.
    a, b : ndarray of shape (n_frames, n_dofs)
        The poses of the two motions, rad, on `skeleton`.
    skeleton : Skeleton or None
        The skeleton on which the motions are compared.
    frame_rate : float or None
        Frame rate of both, Hz; None for arrays.
    metric : Metric
        The distance between poses.

    See Also
    --------
    skpose.plot.AlignmentDisplay : Joints against time as a picture.

    Notes
    -----
    A joint whose rotation differs moves all joints below it: a hip that bends less changes the distances of knee, ankle
    and toes. `joint_rotations` show the joint itself.

    ``pandas.DataFrame(alignment.joint_distances, columns=alignment.skeleton.joint_names)`` is a table with a row for
    each pair of `path`.

    Examples
    --------
    An arm that swings, and once more with an elbow (the second joint) that bends in between:

    >>> import numpy as np
    >>> from skpose import Motion, Skeleton
    >>> from skpose.motions import align_motions
    >>> swing = np.linspace([0, 0], [2, 0], 21)
    >>> bent = swing.copy()
    >>> bent[12, 1] = 0.5
    >>> arm = Skeleton.chain(2)
    >>> alignment = align_motions(Motion(arm, swing, 10), Motion(arm, bent, 10))
    >>> alignment
    Alignment(distance=0.0119 m, 21 pairs of 21 and 21 frames, joint_2 differs most: by 0.495 m at 1.2 s)
    >>> most = alignment.joint_differences("rotation")[0]
    >>> most.joint, round(most.largest, 3), most.frame_a
    ('joint_2', 0.5, 12)
    """

    path: np.ndarray
    distance: float
    distances: np.ndarray
    joint_distances: np.ndarray | None
    joint_rotations: np.ndarray | None
    a: np.ndarray
    b: np.ndarray
    skeleton: Skeleton | None
    frame_rate: float | None
    metric: Metric

    def __repr__(self) -> str:
        frames = f"{len(self.path)} pairs of {len(self.a)} and {len(self.b)} frames"
        most = ""
        if self.joint_distances is not None and self.joint_distances.any():
            off = self.joint_differences()[0]
            when = f"frame {off.frame_a}" if self.frame_rate is None else f"{off.frame_a / self.frame_rate:.4g} s"
            most = f", {off.place} differs most: by {off.largest:.3g} m at {when}"
        return f"Alignment(distance={self.distance:.4g} {self.metric.unit}, {frames}{most})"

    def joint_differences(self, quantity: Quantity = "distance") -> list[JointDifference]:
        """List the difference of each joint, and when it is largest.

        Parameters
        ----------
        quantity : {"distance", "rotation"}, default="distance"
            "distance" compares the positions of a joint, m, "rotation" its rotations relative to its parent, rad. For
            "rotation" joints without dofs are left out.

        Returns
        -------
        list of JointDifference
            One for each joint, the largest difference first.

        Raises
        ------
        ValueError
            For an unknown quantity, or without a skeleton.
        """
        joints, places, values = self._of_joints(quantity)
        rows = values.argmax(axis=0)
        found = [
            JointDifference(name, place, float(column[row]), float(column.mean()), *map(int, self.path[row]))
            for name, place, column, row in zip(joints, places, values.T, rows, strict=True)
        ]
        return sorted(found, key=lambda difference: -difference.largest)

    def _of_joints(self, quantity: Quantity) -> tuple[list[str], list[str], np.ndarray]:
        """Names of joints, their places, and their differences along the path (n_pairs, n), m or rad."""
        check_choice("quantity", quantity, get_args(Quantity))
        if self.skeleton is None or self.joint_distances is None or self.joint_rotations is None:
            raise ValueError("the alignment has no joints: pass skeleton= to align_motions")
        if quantity == "distance":
            return list(self.skeleton.joint_names), joint_places(self.skeleton), self.joint_distances
        places = rotation_places(self.skeleton)
        rotating = [j for j, bone in enumerate(self.skeleton.bones) if bone.dofs]
        names, places = ([all_of[j] for j in rotating] for all_of in (self.skeleton.joint_names, places))
        return names, places, self.joint_rotations[:, rotating]


@validate_params(
    METRIC_CONSTRAINTS
    | {
        "alignment": [StrOptions(["dtw", "subsequence"])],
        "window": [Interval(Real, 0, 1, closed="both"), None],
    },
    prefer_skip_nested_validation=True,
)
def align_motions(
    a: Motion | ArrayLike,
    b: Motion | ArrayLike,
    *,
    skeleton: Skeleton | None = None,
    metric: str | Metric = "auto",
    alignment: str = "dtw",
    window: float | None = None,
) -> Alignment:
    """Align two motions by dynamic time warping, and compare their joints along the path.

    The path of pairs of frames, by steps (1, 0), (0, 1) and (1, 1), has the least sum of distances between poses [1]_,
    see `motion_distances`.

    Parameters
    ----------
    a, b : Motion or array-like of shape (n_frames, n_dofs)
        Two motions: joint angles, and rotation vectors of ball joints, rad.
    skeleton : Skeleton, default=None
        The skeleton of both. None takes it from the `Motion` objects, or their mean. Arrays need it except for "angle";
        without a skeleton joints are not compared.
    metric : str or Metric, default="auto"
        The distance between poses, see `pose_distances`; "auto" is "spatial" with a skeleton, else "angle" with a
        warning.
    alignment : {"dtw", "subsequence"}, default="dtw"
        "dtw" aligns both as a whole. "subsequence" finds `a` inside `b`: the path takes all frames of `a`, and begins
        and ends at any frame of `b`.
    window : float between 0 and 1, default=None
        Sakoe–Chiba band of "dtw", see `motion_distances`. None sets no limit.

    Returns
    -------
    Alignment
        Path, distance, and the differences of the joints along the path.

    Raises
    ------
    TypeError
        If `a` or `b` is a list of motions, or one is a Motion and the other an array.
    ValueError
        If the motions have different frame rates or skeletons that are not comparable; for a window with
        "subsequence".

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.
    UserWarning
        If the poses look like degrees, see `pose_distances`.

    See Also
    --------
    motion_distances : The distances of many motions.
    skpose.plot.AlignmentDisplay : The alignment as a picture.

    Notes
    -----
    Time O(n · m) distances between poses for n and m frames, also with a window. Memory 16 n · m bytes: two motions of
    5,000 frames take 400 MB, so resample long ones.

    `distance` is bit for bit ``motion_distances([a], [b])``. If several paths have the same sum, the path
    prefers diagonal steps.

    References
    ----------
    .. [1] H. Sakoe, S. Chiba, "Dynamic programming algorithm optimization for spoken word recognition", IEEE
       Transactions on Acoustics, Speech, and Signal Processing 26(1), 1978, :doi:`10.1109/TASSP.1978.1163055`.

    Examples
    --------
    The same movement, slower at first:

    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.motions import align_motions
    >>> quick, slow = [[0.0], [1.0], [2.0]], [[0.0], [0.1], [1.0], [2.0]]
    >>> alignment = align_motions(quick, slow, skeleton=Skeleton.chain(1))
    >>> alignment.path.tolist()
    [[0, 0], [0, 1], [1, 2], [2, 3]]
    >>> alignment.joint_distances.ravel().round(3)
    array([0. , 0.1, 0. , 0. ])
    """
    first, second = check_single_motions({"a": a, "b": b}, skeleton)
    skeleton = first.skeleton
    chosen = resolve(metric, skeleton)
    check_alignment(alignment, window, chosen)
    poses_a, poses_b = first.sequences.poses, second.sequences.poses
    if skeleton is not None:
        warn_of_degrees(None, skeleton, a=poses_a, b=poses_b)
    warn_of_no_skeleton(metric, skeleton)
    dtype = np.result_type(poses_a, poses_b)
    rows, columns = (poses.astype(np.float64) if chosen.iterative else poses for poses in (poses_a, poses_b))
    costs, unconverged = DistanceMatrix(rows, columns, chosen, skeleton).write(None, None)
    warn_of_unconverged(unconverged, costs.size)
    is_open = alignment == "subsequence"
    sums = costs.astype(np.float64)
    accumulate(sums, Paths.of(window, is_open))
    column = int(sums[-1].argmin()) if is_open else sums.shape[1] - 1
    path = path_to(sums, is_open, column)
    n_counted = len(poses_a) if is_open else len(poses_a) + len(poses_b)
    return Alignment(
        path=path,
        distance=float((sums[-1, column] / n_counted).astype(dtype)),
        distances=costs[path[:, 0], path[:, 1]],
        joint_distances=None if skeleton is None else _joint_distances(a, b, (poses_a, poses_b), path, skeleton),
        joint_rotations=None
        if skeleton is None
        else np.nan_to_num(joint_rotations(poses_a[path[:, 0]], poses_b[path[:, 1]], skeleton)),
        a=poses_a,
        b=poses_b,
        skeleton=skeleton,
        frame_rate=first.frame_rate,
        metric=chosen,
    )


def _joint_distances(
    a: Motion | ArrayLike, b: Motion | ArrayLike, poses: Sequence[np.ndarray], path: np.ndarray, skeleton: Skeleton
) -> np.ndarray:
    """Distances (n_pairs, n_joints) between the positions of each joint, m."""
    positions = [forward_kinematics(each.astype(np.float64), skeleton) for each in poses]
    if isinstance(a, Motion) and isinstance(b, Motion) and not has_root_joint(skeleton):
        tilts = (Rotation.from_rotvec(each.with_root("tilt").angles[:, :3]) for each in (a, b))
        positions = [np.einsum("nij,nkj->nki", R.as_matrix(), at) for R, at in zip(tilts, positions, strict=True)]
    return np.asarray(np.linalg.norm(positions[1][path[:, 1]] - positions[0][path[:, 0]], axis=2))


def joint_rotations(a: np.ndarray, b: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """Angles (n, n_joints) between the rotations of each joint relative to its parent, rad; NaN without dofs."""
    angles = np.full((len(a), skeleton.n_joints), np.nan)
    for j, (bone, columns) in enumerate(with_columns(skeleton.bones)):
        if bone.dofs:
            of_a, of_b = (rotations_of(bone, poses[:, columns].astype(np.float64)) for poses in (a, b))
            angles[:, j] = (of_a.inv() * of_b).magnitude()
    return angles
