"""`skpose warm-up`: what it has compiled, no later process compiles."""

import os
import re
import subprocess
import sys

import pytest

from skpose._cli.main import main
from skpose._cli.options import SUBJECTS
from skpose._cli.warm_up import CALLS

# How many functions a call compiles: numba does not report those that it finds in its cache.
COUNT = """
from numba.core import event
from skpose import geodesic, pose_distances
from skpose.datasets import make_gait
motion = make_gait(n_subjects=1, n_sequences=1, duration=2.0, frame_rate=12.0, random_state=0)[0]
X, skeleton = motion.angles, motion.skeleton
with event.install_recorder("numba:compile") as recorder:
    {}
print(len(recorder.buffer))
"""
CALL_OF = {
    "distances": "pose_distances(X, skeleton=skeleton)",
    "geodesics": "geodesic(X[0], X[9], skeleton)",
}


def test_options_name_all_subjects():
    assert tuple(CALLS) == SUBJECTS


def test_a_subject_that_there_is_not_is_refused_with_what_is_near(capsys):
    with pytest.raises(SystemExit):
        main(["warm-up", "--for", "geodesic"])
    assert "did you mean 'geodesics'" in capsys.readouterr().err


@pytest.mark.slow
def test_later_processes_compile_nothing(tmp_path):
    def run(*program):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
        done = subprocess.run([sys.executable, *program], env=environment, capture_output=True, text=True, check=True)
        return done.stdout.splitlines()

    first, *subjects, _, cache = run("-m", "skpose", "warm-up", "--for", "distances")
    assert re.fullmatch(r"skpose compiles for \S+, processes: 1", first)
    (seconds,) = (re.fullmatch(r"distances +(\S+) s", line)[1] for line in subjects)
    assert float(seconds) > 1
    size = sum(file.stat().st_size for file in tmp_path.rglob("*.nb?"))
    n_files = len(list(tmp_path.rglob("*.nb?")))
    assert cache == f"{tmp_path}: {n_files} files of compiled functions, {size / 1e6:.0f} MB"
    compiled = {subject: int(run("-c", COUNT.format(call))[0]) for subject, call in CALL_OF.items()}
    assert compiled["distances"] == 0 < compiled["geodesics"]


@pytest.mark.skipif(sys.platform == "win32", reason="a path of other systems")
def test_a_folder_that_cannot_be_written_to_is_refused(tmp_path):
    folder = tmp_path / "file"
    folder.write_text("no folder")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder)}
    program = [sys.executable, "-m", "skpose", "warm-up", "--for", "distances"]
    run = subprocess.run(program, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert f"skpose: NUMBA_CACHE_DIR={folder} is no folder that numba can write to" in run.stderr
