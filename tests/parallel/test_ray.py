"""joblib's backend of ray, in a process of its own."""

import os
import subprocess
import sys

import pytest

PROGRAM = """
import faulthandler
faulthandler.dump_traceback_later(600, exit=True)  # says where it waits for ray, should that take for ever
import joblib, numpy as np, ray
from ray.util.joblib import register_ray
from skpose import PoseKNeighborsTransformer, pose_distances
from skpose.datasets import humanoid
import skpose._utils.parallel, skpose.metrics._matrix, skpose.metrics._matrix, skpose.neighbors._graph
skpose.metrics._matrix.WORTH_SENDING = skpose.neighbors._graph.WORTH_SENDING = 0
skpose.metrics._matrix.ENCODED_AT_ONCE = 64
skeleton = humanoid()
X = np.random.default_rng(0).normal(0, 0.3, size=(200, skeleton.n_dofs))
search = PoseKNeighborsTransformer(skeleton).fit(X)
expected = pose_distances(X, skeleton=skeleton), search.kneighbors()
ray.init(num_cpus=2, include_dashboard=False)
register_ray()
with joblib.parallel_config("ray", n_jobs=2):
    assert skpose._utils.parallel.in_processes(None)
    np.testing.assert_array_equal(pose_distances(X, skeleton=skeleton), expected[0])
    for found, part in zip(search.kneighbors(), expected[1]):
        np.testing.assert_array_equal(found, part)
print("the same")
"""
# Ray's workers have the lowest priority, which on a busy machine is next to no time, and die where memory is short.
SETTINGS = {"RAY_worker_niceness": "0", "RAY_memory_monitor_refresh_ms": "0"}


@pytest.mark.slow
def test_ray_gives_the_same(tmp_path):
    pytest.importorskip("ray")
    with open(tmp_path / "printed", "w") as printed:  # not a pipe, which ray's processes may keep open
        command = [sys.executable, "-c", PROGRAM]
        subprocess.run(command, env=os.environ | SETTINGS, stdout=printed, stderr=printed, check=False)
    lines = (tmp_path / "printed").read_text().splitlines()
    assert "the same" in lines, "\n".join(lines)  # ray prints more
