"""Random skeletons of all kinds of joints with all kinds of limits, and poses inside these."""

import numpy as np
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton

DOFS = "x", "y", "z", "Z", "xy", "ZY", "YX", "xyz", "ZXY", "zyx", "xzy", "YXZ", "rotvec", ""
LIMITS = (-3.0, 2.8), (-np.pi, np.pi), (-np.inf, np.inf), (-1.0, np.inf), (-np.inf, 0.7), (0.3, 0.3), (-7.0, 9.0)


def limited_skeleton(seed):
    """A tree of up to nine bones: some without limits, some without weight; the last one has a hinge with a gap."""
    rng = np.random.default_rng(seed)
    bones = []
    for i in range(rng.integers(2, 9)):
        dofs = str(rng.choice(DOFS))
        pairs = [LIMITS[k] if k < len(LIMITS) else sorted(rng.uniform(-3, 3, 2)) for k in rng.integers(10, size=3)]
        bounded = dofs not in ("rotvec", "") and rng.random() < 0.8
        bones.append(
            Bone(
                f"b{i}",
                f"b{rng.integers(max(0, i - 2), i)}" if i else None,
                rng.normal(0, 0.3, 3),
                dofs,
                Rotation.from_rotvec(rng.normal(size=3)).as_matrix() if rng.random() < 0.3 else None,
                pairs[: len(dofs)] if bounded else None,
                0.0 if rng.random() < 0.15 else None,
            )
        )
    bones.append(Bone("tip", bones[-1].name, (0.3, 0, 0), "z", limits=[(-3.0, 2.8)]))
    return Skeleton(bones, str(rng.choice(["own", "parent"])))


def poses_inside(skeleton, n, seed):
    """Poses inside the limits; three of ten angles are at one."""
    rng = np.random.default_rng(seed)
    lower, upper = np.nan_to_num(skeleton.limits, posinf=4.0, neginf=-4.0).T
    poses = rng.uniform(lower, upper, (n, skeleton.n_dofs))
    ends = np.where(rng.random(poses.shape) < 0.5, lower, upper)
    return np.where(rng.random(poses.shape) < 0.3, ends, poses)


def assert_inside(poses, skeleton):
    """No tolerance: limits are kept to the last bit."""
    assert np.isfinite(poses).all()
    assert (poses >= skeleton.limits[:, 0]).all()
    assert (poses <= skeleton.limits[:, 1]).all()


def hinge(limits, name="arm"):
    """One bone of 1 m with a hinge about z."""
    return Bone(name, None, (1.0, 0.0, 0.0), "z", limits=None if limits is None else (limits,))
