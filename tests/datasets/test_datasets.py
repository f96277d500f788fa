"""CMU folders, and a small copy of CMU's server."""

import functools
import http.server
import shutil
import threading
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from skpose import Skeleton, forward_kinematics
from skpose.datasets import MotionDataset, _cmu, fetch_cmu, load_cmu, make_gait, walks_and_runs
from skpose.io import MocapFormatError, load_asf


@pytest.fixture
def folder(tmp_path):
    """The hand-written arm as two subjects in CMU's own layout."""
    for subject, trials in {"01": ["01", "02"], "02": ["01"]}.items():
        path = tmp_path / "subjects" / subject
        path.mkdir(parents=True)
        asf = (DATA / "arm.asf").read_text()
        (path / f"{subject}.asf").write_text(asf if subject == "01" else asf.replace("length 5.5", "length 6.5"))
        for trial in trials:
            shutil.copy(DATA / "arm.amc", path / f"{subject}_{trial}.amc")
    return tmp_path


def write_index(folder, *lines):
    (folder / "index.csv").write_text("\n".join(["subject,trial,action,frames_per_second,file", *lines]) + "\n")


def test_load_cmu_by_its_layout(folder):
    dataset = load_cmu(folder, frame_rate=60)
    assert list(zip(dataset.subjects, dataset.trials, dataset.actions, strict=True)) == [
        ("01", "01", ""), ("01", "02", ""), ("02", "01", ""),
    ]  # fmt: skip
    assert {motion.frame_rate for motion in dataset} == {60}


def test_load_cmu_by_its_index(folder):
    write_index(folder, "01,02,run/jog,30,subjects/01/01_02.amc", '02,01,"jump, balance",120,subjects/02/02_01.amc')
    dataset = load_cmu(str(folder))
    assert list(dataset.actions) == ["run/jog", "jump, balance"]
    assert [motion.frame_rate for motion in dataset] == [30, 120]


def test_a_rate_that_is_not_known_is_blank_in_the_index_and_assumed_with_a_warning(folder):
    write_index(folder, "01,02,run,,subjects/01/01_02.amc", "02,01,walk,60,subjects/02/02_01.amc")
    with pytest.warns(UserWarning, match="AMC files do not state their frame rate: 120 Hz is taken"):
        assert [motion.frame_rate for motion in load_cmu(folder)] == [120, 60]
    assert [motion.frame_rate for motion in load_cmu(folder, frame_rate=30)] == [30, 60]
    (folder / "index.csv").unlink()
    with pytest.warns(UserWarning, match="120 Hz is taken"):
        assert {motion.frame_rate for motion in load_cmu(folder)} == {120}


@pytest.mark.parametrize(
    ("lines", "match"),
    [
        (["01,01,walk,often,subjects/01/01_01.amc"], "line 2: frames_per_second"),
        (["01,01,walk,120,subjects/01/01_01.amc", "01,02,walk"], "line 3"),
        ([], "no motions"),
    ],
)
def test_errors_of_the_index_name_the_line(folder, lines, match):
    write_index(folder, *lines)
    with pytest.raises(MocapFormatError, match=match):
        load_cmu(folder)


def test_a_dataset_is_compared_on_the_mean_skeleton(folder):
    dataset = load_cmu(folder, frame_rate=120, rotations="file")
    one, other = (load_asf(folder / "subjects" / s / f"{s}.asf") for s in ("01", "02"))
    assert dataset.skeleton == Skeleton.mean([one, other])  # each subject once, not each motion
    X, sequence = dataset.poses()
    assert X.shape == (9, one.n_dofs)
    np.testing.assert_array_equal(sequence, np.repeat([0, 1, 2], 3))
    np.testing.assert_array_equal(dataset.poses(frame_rate=60)[1], np.repeat([0, 1, 2], 2))


def test_a_dataset_has_ball_joints(folder):
    euler, ball = load_cmu(folder, frame_rate=120, rotations="file"), load_cmu(folder, frame_rate=120)
    assert ball.skeleton == euler.skeleton.to_rotvec()
    for a, b in zip(euler, ball, strict=True):
        F = [forward_kinematics(motion.angles, motion.skeleton) for motion in (a, b)]
        np.testing.assert_allclose(*F, atol=1e-12)
    with pytest.raises(ValueError, match="rotations"):
        MotionDataset([], rotations="euler")


def test_walks_and_runs_are_selected_by_the_first_word_of_their_action(folder):
    motions = load_cmu(folder, frame_rate=120).motions
    actions = [" Walk, slow", "run/jog", "walking stick"]
    chosen = walks_and_runs(MotionDataset(motions, ["01", "01", "02"], ["01", "02", "01"], actions))
    assert chosen.motions == motions[:2]
    assert list(zip(chosen.subjects, chosen.trials, chosen.actions, strict=True)) == [
        ("01", "01", "walk"), ("01", "02", "run"),
    ]  # fmt: skip
    with pytest.raises(ValueError, match="run"):
        walks_and_runs(make_gait(1, 1, activities=["walk"], random_state=0))


class Server(http.server.SimpleHTTPRequestHandler):
    """A small copy of CMU's server: the listing of a subject, and files."""

    def do_GET(self):
        if "search.php" in self.path:
            number = int(self.path.split("subjectnumber=")[1].split("&")[0])
            name = f"{number:02}"
            rows = [
                f"{name}_{t}\t{name}_{t}.mpg\t{name}_{t}.c3d\t{name}_{t}.amc\t{a}"
                for t, a in (("01", "walk"), ("02", "run/jog"))
            ]
            known = Path(self.directory, "subjects", name).is_dir()
            text = f"\nSubject #{number} (arm)\n\n" + "\n".join(rows if known else []) + "\n"
            self.send_response(200)
            self.end_headers()
            self.wfile.write(text.encode())
        else:
            super().do_GET()

    def log_message(self, *args):
        pass


@pytest.fixture
def server(folder, monkeypatch):
    handler = functools.partial(Server, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as httpd:
        thread = threading.Thread(target=httpd.serve_forever, args=[0.01])
        thread.start()
        monkeypatch.setattr(_cmu, "SERVER", f"http://127.0.0.1:{httpd.server_port}")
        yield httpd
        httpd.shutdown()
        thread.join()


def test_fetch_cmu(server, folder, tmp_path_factory):
    home = tmp_path_factory.mktemp("home")
    dataset = fetch_cmu([1], data_home=home, frame_rate=120)
    assert list(dataset.actions) == ["walk", "run/jog"]
    assert list(dataset.trials) == ["01", "02"]
    np.testing.assert_array_equal(dataset.motions[1].angles, load_cmu(folder, frame_rate=120).motions[1].angles)
    shutil.rmtree(folder / "subjects")  # now from disk
    assert list(fetch_cmu(["01"], data_home=home, frame_rate=120).actions) == ["walk", "run/jog"]


def test_missing_files_and_folders(folder):
    with pytest.raises(FileNotFoundError, match="neither"):
        load_cmu(folder / "subjects")
    with pytest.raises(FileNotFoundError, match="no folder"):
        load_cmu(folder / "subject")
