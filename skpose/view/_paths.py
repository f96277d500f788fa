"""The player of two paths between two poses: the shortest one, and the straight line."""

from dataclasses import replace
from typing import Literal

import numpy as np

from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_pose
from skpose.geodesics import geodesic
from skpose.kinematics import forward_kinematics
from skpose.kinematics._forward import weighted_positions
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._interpolation import straight_line
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
    straight = straight_line(skeleton.bones, first, last, FINE + 1, TWO_PI)
    if joint_limits == "enforce":
        limited = limited_dofs(skeleton.bones)
        straight[:, limited] = np.linspace(first[limited], last[limited], FINE + 1)
    length = np.linalg.norm(np.diff(weighted_positions(straight, skeleton), axis=0), axis=1).sum()
    paths = {
        f"shortest path, {found.curve_length:.3g} m": found,
        f"straight line, {length:.3g} m": replace(found, path=straight),
    }
    n = int(DURATION * FRAME_RATE) + 1
    motions = [Motion(skeleton, path.resample(n), FRAME_RATE, up=up) for path in paths.values()]
    F, G = (forward_kinematics(motion.angles, skeleton) for motion in motions)
    same = np.repeat(np.arange(n)[:, None], 2, axis=1)
    pairs = pairs_data(same, np.linalg.norm(F - G, axis=2), [range(skeleton.n_joints)] * 2)
    data = [motion_data(motion, label) for motion, label in zip(motions, paths, strict=True)]
    return page(data, pairs, overlay=overlay, title=" and ".join(paths))
