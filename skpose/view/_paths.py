"""The player of two paths between two poses: the shortest one, and the straight line."""

from typing import Literal

import numpy as np

from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_pose
from skpose.geodesics import geodesic
from skpose.kinematics import forward_kinematics
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._interpolation import interpolate_poses, straight_line
from skpose.skeleton._limits import limited_dofs
from skpose.skeleton._rotations import TWO_PI
from skpose.view._page import Page
from skpose.view._player import page, pairs_data
from skpose.view._scene import motion_data

DURATION, FRAME_RATE = 2.0, 30.0  # s, Hz
FINE = 640  # chords by which the straight line is measured


def geodesic_player(
    start: ArrayLike,
    end: ArrayLike,
    skeleton: Skeleton,
    *,
    joint_limits: str = "ignore",
    overlay: bool = False,
    up: Literal["x", "y", "z"] = "y",
) -> Page:
    """Make a page that plays the shortest path between two poses next to the straight line.

    Both take two seconds, at constant speed of all joints together. Colours show the distance of each joint
    from its place on the other path.

    Parameters
    ----------
    start, end : array-like of shape (n_dofs,)
        The two poses: joint angles, rad.
    skeleton : Skeleton
        Their skeleton.
    joint_limits : {"ignore", "enforce"}, default="ignore"
        "enforce" keeps both paths inside ``skeleton.limits``, as `skpose.geodesic` does: no dof with limits goes over
        from π to −π.
    overlay : bool, default=False
        Whether the two start in one picture instead of side by side.
    up : {"x", "y", "z"}, default="y"
        Which axis of the root points up: "z" for robots.

    Returns
    -------
    Page
        Its labels have the lengths of both paths, m, the metrics "geodesic" and "spatial" on a fine grid.

    Raises
    ------
    ValueError
        For poses of the wrong length, or not finite; for poses outside of limits that are enforced.

    Warns
    -----
    ConvergenceWarning
        If the geodesic did not converge, see `skpose.geodesic`.
    UserWarning
        If the poses look like degrees.

    See Also
    --------
    skpose.geodesic : The shortest path as poses.
    skpose.plot.GeodesicDisplay : The two paths in the plane of angles.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.view import geodesic_player
    >>> geodesic_player([0.2, 0.3, 0.0], [2.4, 0.2, 0.1], Skeleton.chain(3)).title
    'shortest path, 7.17 m and straight line, 8.03 m'
    """
    first, last = check_pose(start, skeleton, "start"), check_pose(end, skeleton, "end")
    warn_of_degrees(None, skeleton, start=first[None], end=last[None])
    found = geodesic(first, last, skeleton, joint_limits=joint_limits)
    n = int(DURATION * FRAME_RATE) + 1
    straight = straight_line(skeleton.bones, first, last, FINE + 1, TWO_PI)
    if joint_limits == "enforce":
        limited = limited_dofs(skeleton.bones)
        straight[:, limited] = np.linspace(first[limited], last[limited], FINE + 1)
    line, length = _at_constant_speed(straight, skeleton, n)
    paths = {
        f"shortest path, {found.curve_length:.3g} m": Motion(skeleton, found.resample(n), FRAME_RATE, up=up),
        f"straight line, {length:.3g} m": Motion(skeleton, line, FRAME_RATE, up=up),
    }
    F, G = (forward_kinematics(motion.angles, skeleton) for motion in paths.values())
    same = np.repeat(np.arange(n)[:, None], 2, axis=1)
    pairs = pairs_data(same, np.linalg.norm(F - G, axis=2), [range(skeleton.n_joints)] * 2)
    data = [motion_data(motion, label) for label, motion in paths.items()]
    return page(data, pairs, overlay=overlay, title=" and ".join(paths))


def _at_constant_speed(path: np.ndarray, skeleton: Skeleton, n: int) -> tuple[np.ndarray, float]:
    """The length of a path, m, and n poses at equal lengths along it."""
    weights = np.sqrt(skeleton.weights)[:, None]
    positions = (forward_kinematics(path, skeleton) * weights).reshape(len(path), -1)
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])
    steps = np.arange(len(path), dtype=float)
    where = (
        np.interp(np.linspace(0.0, travelled[-1], n), travelled, steps)
        if travelled[-1]
        else np.linspace(0.0, len(path) - 1, n)
    )
    return interpolate_poses(skeleton.bones, path, where), float(travelled[-1])
