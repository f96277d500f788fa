"""Compiled code against slow references, on skeletons so small that it also runs as plain Python.

``NUMBA_DISABLE_JIT=1 pytest tests/compiled`` runs every function without compilation, for a debugger or for coverage.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import reference
from conftest import MIXED, in_turns, metric_of, random_tree

import skpose
from skpose import Skeleton, forward_kinematics, geodesic, pose_distances, pose_metric
from skpose.kinematics import position_jacobian
from skpose.metrics._registry import METRICS

SMALL = {
    "chain": Skeleton.chain(2),
    "tree": random_tree(0, n=6),
    "mixed joints": random_tree(3, n=6, kinds=MIXED, offset_frame="parent"),
}
WITH_FORMULA = [name for name in METRICS if name != "geodesic"]


@pytest.fixture(params=SMALL)
def small(request):
    return SMALL[request.param]


@pytest.fixture
def some(small):
    """Eleven poses: more than fill one register, and not a multiple."""
    return np.random.default_rng(0).uniform(-3, 3, size=(11, small.n_dofs))


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("metric", WITH_FORMULA)
def test_pairs_agree_with_the_definition(metric, dtype, small, some):
    expected = reference.distances(some[:2], some, small, metric, wrap=True)
    distances = pose_distances(
        some[:2].astype(dtype), some.astype(dtype), skeleton=small, metric=metric_of(metric, wrap=True)
    )
    tolerance = 1e-10 if dtype is np.float64 else 2e-5
    np.testing.assert_allclose(distances, expected, rtol=tolerance, atol=10 * tolerance)


@pytest.mark.filterwarnings("ignore:ball trees:UserWarning")
@pytest.mark.parametrize(("metric", "small"), in_turns(WITH_FORMULA, list(SMALL)), indirect=["small"])
def test_scalars_and_lanes_agree(metric, small, some):
    function = pose_metric(metric=metric, skeleton=small)
    expected = pose_distances(some[:1], some, skeleton=small, metric=metric)[0]
    np.testing.assert_allclose([function(some[0], x) for x in some], expected, rtol=1e-12, atol=1e-12)


def test_a_geodesic_is_between_chord_and_line():
    arm, poses = SMALL["chain"], np.array([[0.2, 0.3], [0.9, -0.2]])
    chord, shortest, line = (
        pose_distances(poses, skeleton=arm, metric=metric)[0, 1] for metric in ("position", "geodesic", "spatial")
    )
    assert chord <= shortest <= line
    assert geodesic(*poses, arm).length == pytest.approx(shortest, rel=1e-6)


def test_positions_and_jacobians(small, some):
    np.testing.assert_allclose(
        forward_kinematics(some, small), reference.forward_kinematics(some, small), rtol=0, atol=1e-12
    )
    h, numeric = 1e-5, np.empty((len(some), 3 * small.n_joints, small.n_dofs))
    for d in range(small.n_dofs):
        step = h * np.eye(small.n_dofs)[d]
        ahead, behind = (forward_kinematics(some + sign * step, small) for sign in (1, -1))
        numeric[:, :, d] = ((ahead - behind) / (2 * h)).reshape(len(some), -1)
    np.testing.assert_allclose(position_jacobian(some, small), numeric, atol=1e-8)


def run(code, folder, **environment):
    """What a new process prints that imports skpose from a folder."""
    environment = os.environ | {"PYTHONPATH": str(folder)} | environment
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.slow
def test_plain_python_gives_the_same_distance():
    code = """
from skpose import Skeleton, pose_distances
print(pose_distances([[0.1, 0.2]], [[1.3, -0.4]], skeleton=Skeleton.chain(2)).round(12)[0, 0])
"""
    folder = Path(skpose.__file__).parents[1]
    assert run(code, folder, NUMBA_DISABLE_JIT="1") == run(code, folder, NUMBA_DISABLE_JIT="0")


@pytest.mark.slow
@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled, so nothing is cached")
def test_an_edit_of_any_compiled_source_is_seen(tmp_path):
    """Not only of the file of the function that is called: numba's own cache sees no more than that."""
    package = tmp_path / "skpose"
    shutil.copytree(Path(skpose.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    code = "from skpose import pose_distances; print(pose_distances([[0.0, 0.0]], [[3.0, 4.0]], metric='angle')[0, 0])"
    assert [run(code, tmp_path) for _ in range(2)] == ["5.0", "5.0"]
    source = package / "_compiled" / "simd" / "lanes_llvm.py"
    before = source.read_text(encoding="utf-8")
    edited = before.replace('_define_unary(lanes.sqrt, "sqrt")', '_define_unary(lanes.sqrt, "fabs")')
    assert edited != before
    source.write_text(edited, encoding="utf-8")
    assert run(code, tmp_path) == "25.0"  # the sum of the squares instead of its square root
