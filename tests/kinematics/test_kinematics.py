import numpy as np
import pytest
import reference
from competition import Competition
from joblib import parallel_config

from skpose import Bone, Skeleton, forward_kinematics, metric_tensor, position_jacobian
from skpose._parallel import rows


def test_positions_agree_with_the_reference(skeleton, poses):
    np.testing.assert_allclose(
        forward_kinematics(poses, skeleton), reference.forward_kinematics(poses, skeleton), atol=1e-12
    )


def test_positions_of_a_planar_arm_in_closed_form():
    angles = np.random.default_rng(0).uniform(-7, 7, size=(5, 6))
    direction = np.cumsum(angles, axis=1)
    expected = np.cumsum(np.stack([np.cos(direction), np.sin(direction), 0 * direction], axis=-1), axis=1)
    np.testing.assert_allclose(forward_kinematics(angles, Skeleton.chain(6)), expected, atol=1e-12)


def test_axes_in_every_order_with_every_number_of_dofs():
    axes = [""] + [a + b + c for a in "xyz" for b in ["", *"xyz"] for c in ["", *"xyz"]]
    axes = sorted({order for order in axes if len(set(order)) == len(order)})
    for order in [*axes, *(order.upper() for order in axes)]:
        for frame in ("own", "parent"):
            bones = [Bone("a", None, (1, 2, 3), order), Bone("b", "a", (3, -1, 2), "zyx"), Bone("c", "b", (1, 1, 0))]
            skeleton = Skeleton(bones, frame)
            angles = np.random.default_rng(0).normal(size=(3, skeleton.n_dofs))
            expected = reference.forward_kinematics(angles, skeleton)
            np.testing.assert_allclose(forward_kinematics(angles, skeleton), expected, atol=1e-12, err_msg=order)


def test_bone_lengths_never_change(skeleton, poses):
    positions = forward_kinematics(poses, skeleton)
    starts = np.where((skeleton.parents >= 0)[:, None], positions[:, skeleton.parents], 0)
    lengths = np.linalg.norm(positions - starts, axis=2)
    np.testing.assert_allclose(lengths, np.tile(np.linalg.norm(skeleton.offsets, axis=1), (len(poses), 1)), atol=1e-12)


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


def test_the_number_of_threads_changes_nothing(skeleton, poses, monkeypatch):
    competition = Competition()
    many = np.concatenate([poses + 0.01 * k for k in range(5)])  # no whole number of registers in a task
    for angles in (many, many.astype(np.float32)):
        expected = forward_kinematics(angles, skeleton)
        with monkeypatch.context() as small:
            small.setattr(rows, "LITTLE_WORK", 1.0)
            small.setattr(rows, "in_threads", competition)
            for n_jobs in (2, 3):
                np.testing.assert_array_equal(forward_kinematics(angles, skeleton, n_jobs=n_jobs), expected)
            with parallel_config(n_jobs=4):
                np.testing.assert_array_equal(forward_kinematics(angles, skeleton), expected)
    assert competition.n_threads == [2, 3, 4] * 2


def test_one_pose_on_all_processors():
    skeleton = Skeleton.chain(2)
    expected = forward_kinematics([[0.0, 1.0]], skeleton)
    np.testing.assert_array_equal(forward_kinematics([[0.0, 1.0]], skeleton, n_jobs=-1), expected)


@pytest.mark.parametrize(("n_jobs", "message"), [(0, "n_jobs == 0"), (1.5, "The 'n_jobs' parameter of forward_kinem")])
def test_wrong_numbers_of_threads_are_refused(n_jobs, message):
    with pytest.raises(ValueError, match=message):
        forward_kinematics([[0.0, 1.0]], Skeleton.chain(2), n_jobs=n_jobs)


def test_wrong_width_is_refused_in_the_users_words():
    expected = (
        "angles has 5 columns, but the skeleton has 4 degrees of freedom: one column per name in skeleton.dof_names"
    )
    for function in (forward_kinematics, position_jacobian, metric_tensor):
        with pytest.raises(ValueError, match=expected):
            function(np.zeros((2, 5)), Skeleton.chain(4))
        with pytest.raises(ValueError, match="angles contains NaN"):
            function(np.full((2, 4), np.nan), Skeleton.chain(4))
        with pytest.raises(TypeError, match=r"skeleton must be a skpose.Skeleton, got str"):
            function(np.zeros((2, 4)), "chain")


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
