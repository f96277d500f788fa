"""Reader of robots: MJCF and URDF, by MuJoCo."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from skpose._typing import ArrayLike
from skpose.io._arguments import Readable
from skpose.io._robot_bones import build_robot
from skpose.io._robot_file import read_robot
from skpose.skeleton import Skeleton

if TYPE_CHECKING:
    import mujoco


def load_robot(
    path: "Readable | mujoco.MjModel",
    *,
    root: str | None = None,
    held: Mapping[str, ArrayLike] | None = None,
) -> Skeleton:
    """Read the skeleton of a robot from an MJCF or URDF file, as MuJoCo reads it.

    The joints of the skeleton are the robot's links (MuJoCo's bodies), by their names, in MuJoCo's order. The columns
    of its poses are the robot's joints, by theirs, in the order of ``qpos`` and with its numbers.

    Parameters
    ----------
    path : str, path-like, file or mujoco.MjModel
        The file, an open one that includes no others, or a model that MuJoCo has compiled.
    root : str, default=None
        The link that is the root of the skeleton; what it does not carry is left out. None is the link with the free
        joint. Where no link with joints moves freely it is the first link of a URDF file, and "world" otherwise.
    held : mapping of str to float or array-like, default=None
        Joints that stay at a value, and are no columns: rad for a hinge, m for a slide, a rotation vector (3,) in rad
        for a ball joint.

    Returns
    -------
    Skeleton
        With ``offset_frame="parent"``. A hinge or a slide is a column with the name of the joint, in rad or m; a ball
        joint has three, the rotation vector that `Bone` describes. Limits are those of the joints that have any.

    Raises
    ------
    ImportError
        If MuJoCo is not installed.
    MocapFormatError
        If MuJoCo cannot read the file, in its words; if several links with joints move freely and no `root` is
        chosen; for a name in `root` or `held` that is not in the file, and a value beyond the joint's limits.
    OSError
        If the file cannot be read.

    Warns
    -----
    UserWarning
        For what poses of the skeleton do not keep, with the names: equality constraints, mimic joints of URDF files
        (each has a column of its own), tendons, limits of ball joints; for links and joints that are left out,
        by a `root`, or as objects next to the robot.

    See Also
    --------
    motion_from_qpos : Return numbers of MuJoCo as a motion.
    qpos_from_motion : Return a motion as numbers of MuJoCo.

    Notes
    -----
    Geometry, masses, motors and sensors are left out before MuJoCo compiles the model: missing meshes and textures,
    such as those at ``package://``, are no error, nor are links without a mass. No link is fused with another one.

    A link without a name is "body_3", by its number in MuJoCo; a joint without a name is that of its link and "_joint".
    A link with several joints has bones of length zero for all but the last, and a joint at another point than the
    origin of its link one bone to this point and a rigid one back: these bones are called by the joint and "_anchor".
    Positions and orientations of the links are those of MuJoCo, relative to the root, to the last digits.

    Where anchors are at other points than links, distances count them as points of the robot too;
    `Skeleton.with_weights` with zeros leaves them out.

    Examples
    --------
    >>> import io
    >>> from skpose.io import load_robot
    >>> arm = load_robot(io.StringIO('''
    ...     <mujoco>
    ...       <worldbody>
    ...         <body name="upper_arm" pos="0 0 1">
    ...           <joint name="shoulder" axis="0 1 0" range="-90 90"/>
    ...           <body name="forearm" pos="0.3 0 0">
    ...             <joint name="elbow" axis="0 1 1"/>
    ...             <body name="hand" pos="0.25 0 0"/>
    ...           </body>
    ...         </body>
    ...       </worldbody>
    ...     </mujoco>'''))
    >>> arm.joint_names, arm.dof_names
    (('upper_arm', 'forearm', 'hand'), ('shoulder', 'elbow'))
    >>> arm.limits.round(2)
    array([[-1.57,  1.57],
           [ -inf,   inf]])
    """
    file = read_robot(path, "load_robot")
    robot = build_robot(file, root, held)
    file.warn(robot.notes)
    return robot.skeleton
