"""Collections of motions: generated gait, CMU folders, and a small copy of CMU's server."""

import functools
import http.server
import shutil
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from skpose import Skeleton, forward_kinematics
from skpose.datasets import MotionDataset, _cmu, _gait, fetch_cmu, humanoid, load_cmu, make_gait, walks_and_runs
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


def test_load_cmu_names_what_is_missing(folder, tmp_path):
    write_index(folder, "01,09,walk,120,subjects/01/01_09.amc")
    with pytest.raises(FileNotFoundError, match=r"01_09\.amc is missing, but .*index\.csv refers to it"):
        load_cmu(folder)
    write_index(folder, "01,01,walk,often,subjects/01/01_01.amc")
    with pytest.raises(
        MocapFormatError, match=r"index\.csv, line 2: frames_per_second: expected a positive number, found 'often'"
    ):
        load_cmu(folder)
    write_index(folder, "01,01,walk,0,subjects/01/01_01.amc")
    with pytest.raises(MocapFormatError, match="line 2: frames_per_second: expected a positive number"):
        load_cmu(folder)
    write_index(folder, "01,01,walk,120,subjects/01/01_01.amc", "01,02,walk")
    with pytest.raises(MocapFormatError, match="line 3: expected a value for each of subject, trial, action"):
        load_cmu(folder)
    write_index(folder)
    with pytest.raises(MocapFormatError, match="the index names no motions"):
        load_cmu(folder)
    (folder / "index.csv").write_text("subject,trial\n01,01\n")
    with pytest.raises(MocapFormatError, match="missing: action, frames_per_second, file"):
        load_cmu(folder)
    with pytest.raises(FileNotFoundError, match=r"holds neither an index\.csv nor files named"):
        load_cmu(tmp_path / "nowhere")


def test_a_dataset_is_compared_on_the_mean_skeleton(folder):
    dataset = load_cmu(folder)
    one, other = (load_asf(folder / "subjects" / s / f"{s}.asf") for s in ("01", "02"))
    assert dataset.skeleton == Skeleton.mean([one, other])  # each subject once, not each motion
    X, sequence = dataset.poses()
    assert X.shape == (9, one.n_dofs)
    np.testing.assert_array_equal(sequence, np.repeat([0, 1, 2], 3))
    np.testing.assert_array_equal(dataset.poses(frame_rate=60)[1], np.repeat([0, 1, 2], 2))


def test_select_by_mask_and_by_index(folder):
    dataset = load_cmu(folder)
    for chosen in (dataset.trials == "01", [0, 2]):
        part = dataset.select(chosen)
        assert list(part.subjects) == ["01", "02"]
        assert part.motions == (dataset.motions[0], dataset.motions[2])
    with pytest.raises(ValueError, match="subjects must have one label for each of the 3 motions"):
        MotionDataset(dataset.motions, ["01"], dataset.trials, dataset.actions)


def test_motions_of_one_asf_file_share_its_skeleton(folder):
    one, same, other = load_cmu(folder)
    assert one.skeleton is same.skeleton
    assert one.skeleton != other.skeleton


def test_walks_and_runs_are_selected_by_the_first_word_of_their_action(folder):
    motions = load_cmu(folder).motions
    actions = [" Walk, slow", "run/jog", "walking stick"]
    chosen = walks_and_runs(MotionDataset(motions, ["01", "01", "02"], ["01", "02", "01"], actions))
    assert chosen.motions == motions[:2]
    assert list(zip(chosen.subjects, chosen.trials, chosen.actions, strict=True)) == [
        ("01", "01", "walk"), ("01", "02", "run"),
    ]  # fmt: skip
    with pytest.raises(ValueError, match=r"dataset must have .* of running, but none has .* begins with 'run'"):
        walks_and_runs(make_gait(1, 1, activities=["walk"], random_state=0))


def test_gait_is_determined_by_its_seed():
    one, same, other = (make_gait(2, 1, random_state=seed) for seed in (0, 0, 1))
    for a, b, c in zip(one, same, other, strict=True):
        np.testing.assert_array_equal(a.angles, b.angles)
        assert a.skeleton == b.skeleton
        assert not np.array_equal(a.angles, c.angles)


def test_gait_has_the_requested_motions():
    gait = make_gait(3, 2, activities=["run"], duration=1.5, frame_rate=20, random_state=0)
    assert len(gait) == 6
    assert set(gait.actions) == {"run"}
    assert list(gait.subjects) == ["01", "01", "02", "02", "03", "03"]
    assert all(len(motion) == 30 and motion.frame_rate == 20 for motion in gait)
    with pytest.raises(ValueError, match=r"activities must be among \['walk', 'run'\], got 'swim'"):
        make_gait(activities=["walk", "swim"])
    with pytest.raises(ValueError, match="The 'n_subjects' parameter of make_gait must be"):
        make_gait(0)


# Degrees and hundredths of the gait cycle within which curves of healthy adults peak.
PUBLISHED_PEAKS = {
    ("walk", "hip_flexion", "max"): ((18, 38), (80, 112)),
    ("walk", "hip_flexion", "min"): ((-25, -2), (35, 65)),
    ("walk", "knee_flexion", "max"): ((45, 78), (60, 85)),
    ("walk", "ankle_dorsiflexion", "max"): ((2, 18), (28, 55)),
    ("walk", "ankle_dorsiflexion", "min"): ((-30, -8), (50, 72)),
    ("run", "hip_flexion", "max"): ((45, 65), (70, 95)),
    ("run", "knee_flexion", "max"): ((80, 110), (55, 80)),
    ("run", "ankle_dorsiflexion", "max"): ((15, 32), (10, 30)),
    ("run", "ankle_dorsiflexion", "min"): ((-30, -12), (30, 55)),
}


@pytest.mark.parametrize(("activity", "curve", "peak"), PUBLISHED_PEAKS)
def test_gait_curves_peak_at_the_published_times(activity, curve, peak):
    (low, high), (early, late) = PUBLISHED_PEAKS[activity, curve, peak]
    cycle = np.linspace(0, 1, 500, endpoint=False)
    values = _gait._evaluate(_gait._series(_gait._CURVES[activity][curve]), cycle)
    at = values.argmax() if peak == "max" else values.argmin()
    assert low < values[at] < high
    assert early <= 100 * cycle[at] <= late or early <= 100 * cycle[at] + 100 <= late


@pytest.mark.parametrize("activity", ["walk", "run"])
def test_six_harmonics_reproduce_the_curves(activity):
    """The Fourier series differs from the points that it is made from by at most twice their rounding."""
    for curve, points in _gait._CURVES[activity].items():
        fitted = _gait._evaluate(_gait._series(points), np.arange(len(points)) / len(points))
        assert np.abs(fitted - points).max() < 1.0, curve


def test_gait_moves_like_gait():
    """Feet alternate, arms swing against the legs, and running flexes knees and elbows more than walking."""
    gait = make_gait(4, 1, random_state=0)
    flexion = {}
    for motion, action in zip(gait, gait.actions, strict=True):
        P = dict(
            zip(
                motion.skeleton.joint_names,
                forward_kinematics(motion.angles, motion.skeleton).swapaxes(0, 1),
                strict=True,
            )
        )
        z = {name: P[name][:, 2] for name in P}
        assert np.corrcoef(z["left_foot"], z["right_foot"])[0, 1] < -0.5
        assert np.corrcoef(z["left_hand"], z["left_foot"])[0, 1] < -0.3
        assert P["head"][:, 1].min() > 0.3
        assert P["left_foot"][:, 1].max() < 0
        angles = dict(zip(motion.skeleton.dof_names, np.degrees(motion.angles).T, strict=True))
        flexion.setdefault(action, []).append((angles["left_shank_rx"].max(), -angles["left_forearm_rx"].mean()))
    knee, elbow = (np.mean(flexion["run"], axis=0) - np.mean(flexion["walk"], axis=0)).tolist()
    assert knee > 15
    assert elbow > 40


def test_subjects_differ_in_height_and_proportions():
    skeletons = [motion.skeleton for motion in make_gait(5, 1, activities=["walk"], random_state=0)]
    lengths = np.array([np.linalg.norm(skeleton.offsets, axis=1) for skeleton in skeletons])
    assert (lengths.std(axis=0) > 0).all()
    shares = lengths / lengths.sum(axis=1, keepdims=True)
    assert (shares.std(axis=0) > 0).all()


def test_humanoid_has_the_requested_height():
    for height in (1.5, 2.0):
        skeleton = humanoid(height)
        P = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]
        P = dict(zip(skeleton.joint_names, P, strict=True))
        np.testing.assert_allclose(P["head"][1] - P["left_foot"][1], height, rtol=0.01)
        np.testing.assert_allclose(P["left_hand"] * [-1, 1, 1], P["right_hand"], atol=1e-12)
    longer = humanoid(proportions={"thigh": 2.0})
    ratio = np.linalg.norm(longer.offsets, axis=1) / np.linalg.norm(humanoid().offsets, axis=1)
    assert {name for name, r in zip(longer.joint_names, ratio, strict=True) if r > 1.5} == {"left_thigh", "right_thigh"}
    with pytest.raises(ValueError, match=r"proportions names \['tail'\]"):
        humanoid(proportions={"tail": 2.0})
    for height in (0, -1.7, np.nan, np.inf, "1.7", None):
        with pytest.raises(ValueError, match="The 'height' parameter of humanoid must be"):
            humanoid(height)
    for factor in (0, -1, np.nan, "1"):
        with pytest.raises(ValueError, match=r"proportions must be positive numbers, got .* for 'thigh'"):
            humanoid(proportions={"thigh": factor})


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
        monkeypatch.setattr(_cmu, "DIGESTS", {})
        yield httpd
        httpd.shutdown()
        thread.join()


def test_fetch_cmu(server, folder, tmp_path_factory, monkeypatch):
    home = tmp_path_factory.mktemp("home")
    dataset = fetch_cmu([1], data_home=home)
    assert list(dataset.actions) == ["walk", "run/jog"]
    assert list(dataset.trials) == ["01", "02"]
    np.testing.assert_array_equal(dataset.motions[1].angles, load_cmu(folder).motions[1].angles)
    shutil.rmtree(folder / "subjects")  # now from disk
    assert list(fetch_cmu(["01"], data_home=home).actions) == ["walk", "run/jog"]
    monkeypatch.setattr(_cmu, "DIGESTS", {"01_01.amc": "0" * 64})
    with pytest.warns(UserWarning, match=r"01_01\.amc is not the 01_01\.amc that skpose's figures were measured on"):
        fetch_cmu([1], data_home=home)


def test_fetch_cmu_of_an_unknown_subject(server, tmp_path_factory):
    with pytest.raises(OSError, match="the CMU server lists no motions of subject 77"):
        fetch_cmu([77], data_home=tmp_path_factory.mktemp("home"))
    with pytest.raises(ValueError, match="subjects must name at least one subject"):
        fetch_cmu([], data_home=tmp_path_factory.mktemp("home"))


@pytest.mark.filterwarnings("ignore:Retry downloading:UserWarning")
def test_fetch_cmu_without_a_network(tmp_path, monkeypatch):
    monkeypatch.setattr(_cmu, "SERVER", "http://127.0.0.1:9")
    monkeypatch.setattr(time, "sleep", lambda seconds: None)  # scikit-learn's, between attempts
    with pytest.raises(OSError, match=r"could not download http://127.0.0.1:9.*Is there a network\? Without one"):
        fetch_cmu([2], data_home=tmp_path)


def test_digests_are_those_of_the_real_files(cmu_folder):
    for path in (cmu_folder / "subjects").glob("*/*"):
        assert _cmu.DIGESTS.get(path.name, _cmu.digest(path)) == _cmu.digest(path)
    assert len(_cmu.DIGESTS) > 10
