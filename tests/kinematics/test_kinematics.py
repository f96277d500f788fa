import numpy as np
import pytest
import reference

from skpose import Skeleton, forward_kinematics
from skpose.kinematics import metric_tensor, position_jacobian


def test_positions_agree_with_the_reference(skeleton, poses):
    np.testing.assert_allclose(
        forward_kinematics(poses, skeleton), reference.forward_kinematics(poses, skeleton), atol=1e-12
    )


def test_positions_of_a_planar_arm_in_closed_form():
    angles = np.random.default_rng(0).uniform(-7, 7, size=(5, 6))
    direction = np.cumsum(angles, axis=1)
    expected = np.cumsum(np.stack([np.cos(direction), np.sin(direction), 0 * direction], axis=-1), axis=1)
    np.testing.assert_allclose(forward_kinematics(angles, Skeleton.chain(6)), expected, atol=1e-12)


def test_jacobian_agrees_with_central_differences(skeleton, poses):
    h = 1e-5
    numeric = np.empty((len(poses), 3 * skeleton.n_joints, skeleton.n_dofs))
    for d in range(skeleton.n_dofs):
        step = h * np.eye(skeleton.n_dofs)[d]
        ahead, behind = (forward_kinematics(poses + sign * step, skeleton) for sign in (1, -1))
        numeric[:, :, d] = ((ahead - behind) / (2 * h)).reshape(len(poses), -1)
    np.testing.assert_allclose(position_jacobian(poses, skeleton), numeric, atol=1e-8)


def test_metric_tensor_gives_the_speed_of_the_joints(skeleton, poses):
    velocity, h = np.random.default_rng(1).normal(size=skeleton.n_dofs), 1e-6
    ahead, behind = (reference.F(poses + sign * h * velocity, skeleton) for sign in (1, -1))
    speed = np.linalg.norm(ahead - behind, axis=1) / (2 * h)
    tensor = metric_tensor(poses, skeleton)
    np.testing.assert_allclose(np.sqrt(velocity @ (tensor @ velocity)[..., None])[:, 0], speed, rtol=1e-7)
    np.testing.assert_array_equal(tensor, tensor.transpose(0, 2, 1))
    assert np.linalg.eigvalsh(tensor).min() > -1e-10 * np.linalg.eigvalsh(tensor).max()


def test_float32_in_float32_out(skeleton, poses):
    for function in (forward_kinematics, position_jacobian, metric_tensor):
        exact, single = function(poses, skeleton), function(poses.astype(np.float32), skeleton)
        assert (exact.dtype, single.dtype) == (np.float64, np.float32)
        np.testing.assert_allclose(single, exact, atol=1e-5 * np.abs(exact).max())


def test_the_number_of_threads_changes_nothing():
    poses = np.random.default_rng(0).normal(size=(50_000, 6))
    expected = forward_kinematics(poses, Skeleton.chain(6))
    np.testing.assert_array_equal(forward_kinematics(poses, Skeleton.chain(6), n_jobs=2), expected)


@pytest.mark.parametrize("function", [forward_kinematics, position_jacobian, metric_tensor])
def test_poses_of_another_skeleton_are_refused(function):
    for angles, message in ((np.zeros((2, 5)), "5 columns"), (np.full((2, 4), np.nan), "NaN")):
        with pytest.raises(ValueError, match=message):
            function(angles, Skeleton.chain(4))


@pytest.mark.slow
def test_every_cmu_file_agrees_with_the_reference(cmu, cmu_folder):
    """Joint positions within 1e-9 m of a reader and a forward kinematics that share nothing with the library's."""
    for motion, subject, trial in zip(cmu.motions, cmu.subjects, cmu.trials, strict=True):
        stem = cmu_folder / "subjects" / subject / subject
        expected, names = reference.asf_amc_positions(f"{stem}.asf", f"{stem}_{trial}.amc")
        positions = forward_kinematics(motion.angles, motion.skeleton)
        assert motion.skeleton.joint_names == tuple(names)
        assert np.abs(positions - expected).max() < 1e-9, f"{subject}_{trial}"


def test_rank_of_the_cmu_jacobian(cmu):
    """Twists of bones that end a chain move nothing: 50 of 56 dofs can be seen."""
    skeleton = cmu.motions[0].skeleton
    assert (skeleton.n_joints, skeleton.n_dofs) == (30, 56)
    ranks = np.linalg.matrix_rank(position_jacobian(cmu.motions[0].angles[::50], skeleton), tol=1e-8)
    np.testing.assert_array_equal(ranks, 50)
