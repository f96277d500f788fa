"""Skeletons of all kinds, and real files where variables such as SKPOSE_CMU name their folders."""

import os
import sys

os.environ.setdefault("SCIPY_ARRAY_API", "1")  # before scipy: without it scikit-learn skips one of its checks
os.environ["MPLBACKEND"] = "template"  # a matplotlib backend that draws nothing, and has no warning about it
if "PYTEST_XDIST_WORKER" in os.environ:  # before numpy: with a worker on each processor, threads of BLAS only wait
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_NUM_THREADS", "1")

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton, forward_kinematics
from skpose.datasets import humanoid, load_cmu, load_hdm05, make_gait
from skpose.io import load_asf, load_bvh, save_bvh
from skpose.metrics import Angle
from skpose.metrics._registry import METRICS

DATA = Path(__file__).parent / "data"
RECORDINGS = {"cmu", "hdm05"}  # fixtures that read whole collections


def pytest_collection_modifyitems(items):
    """Tests of real recordings are slow. Leave out warnings of units that are right about what tests make up.

    Files of tests of the readers have bones of round lengths: skeletons of any size. scikit-learn's checks have columns
    of any numbers, here on a chain of joints.
    """
    for item in items:
        if not RECORDINGS.isdisjoint(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.slow)
        if "check" in getattr(getattr(item, "callspec", None), "params", {}):
            item.add_marker(pytest.mark.filterwarnings("ignore:values of X reach:UserWarning"))
        if item.path.parent.name in ("io", "cli"):
            item.add_marker(pytest.mark.filterwarnings("ignore:.* m from end to end in the rest pose:UserWarning"))


@pytest.fixture(autouse=True)
def no_open_figures():
    """Close the figures of a test; matplotlib warns if there are many."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.fixture
def agg():
    """A backend of matplotlib that draws."""
    plt = pytest.importorskip("matplotlib.pyplot")
    before = plt.get_backend()
    plt.switch_backend("agg")
    yield
    plt.switch_backend(before)


@pytest.fixture
def walks_in_folder(tmp_path, monkeypatch):
    """The current folder, with files of two walks of two people, of 1 and 0.7 s: anna.bvh and ben.bvh."""
    monkeypatch.chdir(tmp_path)
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=20, random_state=0)
    walks = gait[gait.actions == "walk"].motions
    for name, motion, n_frames in zip(("anna.bvh", "ben.bvh"), walks, (20, 14), strict=True):
        save_bvh(name, motion[:n_frames], scale=1.0)
    return tmp_path


@pytest.fixture(scope="session")
def cmu_folder():
    """The folder of CMU files named by SKPOSE_CMU; a wrong folder is a failure, and without one the test is skipped."""
    folder = os.environ.get("SKPOSE_CMU")
    if folder is None:
        pytest.skip("SKPOSE_CMU does not name a folder of CMU files")
    assert Path(folder, "index.csv").is_file(), f"SKPOSE_CMU={folder} has no index.csv"
    return Path(folder).resolve()  # tests change the folder they work in


@pytest.fixture(scope="session")
def cmu(cmu_folder):
    return load_cmu(cmu_folder, rotations="file")


@pytest.fixture(scope="session")
def robots_folder():
    """The folder of robots (MJCF) named by SKPOSE_ROBOTS; a wrong folder is a failure, and without one: skipped."""
    folder = os.environ.get("SKPOSE_ROBOTS")
    if folder is None:
        pytest.skip("SKPOSE_ROBOTS does not name a folder of robots")
    assert list(Path(folder).glob("*.xml")), f"SKPOSE_ROBOTS={folder} has no files named *.xml"
    return Path(folder).resolve()


@pytest.fixture(scope="session")
def hdm05_folder():
    """The folder of HDM05 files named by SKPOSE_HDM05; a wrong folder is a failure, and without one: skipped."""
    folder = os.environ.get("SKPOSE_HDM05")
    if folder is None:
        pytest.skip("SKPOSE_HDM05 does not name a folder of HDM05 files")
    assert list(Path(folder).rglob("HDM_*.amc")), f"SKPOSE_HDM05={folder} has no files named HDM_*.amc"
    return Path(folder).resolve()  # tests change the folder they work in


@pytest.fixture(scope="session")
def hdm05(hdm05_folder):
    return load_hdm05(hdm05_folder, rotations="file")


@pytest.fixture(scope="session")
def opensim_folder():
    """The folder of markers and OpenSim's angles named by SKPOSE_OPENSIM; a wrong folder is a failure."""
    folder = os.environ.get("SKPOSE_OPENSIM")
    if folder is None:
        pytest.skip("SKPOSE_OPENSIM does not name a folder of markers with OpenSim's angles")
    assert list(Path(folder).glob("*_ik.mot")), f"SKPOSE_OPENSIM={folder} has no files named *_ik.mot"
    return Path(folder).resolve()


ANGLES = "xyz", "ZXY", "", "y", "xz", "ZY", "yxz", "X", "YZX", "zy", "XZY", "zyx"
MIXED = "rotvec", "ZXY", "", "hinge", "rotvec", "rotvec", "rotvec", "X", "YZX", "zy", "hinge", "rotvec"


def random_tree(seed, n=12, offset_frame="own", kinds=ANGLES):
    """A branching skeleton with joints of these kinds in turn, rest rotations, and rigid joints."""
    rng = np.random.default_rng(seed)
    bones = []
    for i in range(n):
        parent = None if i < 2 else f"b{rng.integers(i)}"
        rest = Rotation.from_rotvec(rng.normal(size=3)).as_matrix() if i % 3 else None
        kind = kinds[i % len(kinds)]
        offset = rng.normal(size=3)
        axis = None if kind not in ("hinge", "slide") else (0.0, -1.0, 0.0) if i % 4 == 0 else rng.normal(size=3)
        bones.append(Bone(f"b{i}", parent, offset, kind, rest, axis=axis))
    return Skeleton(bones, offset_frame)


def weighted(skeleton, seed):
    """The skeleton with random weights: none for some joints that carry others, none for a whole branch."""
    rng = np.random.default_rng(seed)
    weights = rng.uniform(0.1, 3.0, skeleton.n_joints) * (rng.uniform(size=skeleton.n_joints) > 0.3)
    unseen = skeleton.select(drop=skeleton.bones[skeleton.n_joints // 2].name).joint_names
    return skeleton.with_weights(
        [w if n in unseen else 0.0 for w, n in zip(weights, skeleton.joint_names, strict=True)]
    )


def in_space(motion):
    """Return joint positions (n_frames, n_joints, 3) with the root's movement, m."""
    rotation = Rotation.from_euler(motion.root_axes, motion.root_angles)
    F = forward_kinematics(motion.angles, motion.skeleton)
    return np.stack([rotation.apply(F[:, i]) for i in range(F.shape[1])], axis=1) + motion.root_positions[:, None]


def whole_turns(poses, skeleton, numbers):
    """What changes no rotation: whole turns of angles, of rotation vectors along themselves (by the last number)."""
    turns, column = 2 * np.pi * numbers.astype(float), 0
    for bone in skeleton.bones:
        here = slice(column, column + bone.n_dofs)
        column = here.stop
        if bone.is_ball:
            vectors = poses[:, here]
            turns[:, here] = turns[:, [column - 1]] * vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return turns


def metric_of(name, **parameters):
    """Return the metric of a name, with those of the parameters that it has."""
    metric = METRICS[name]()
    return metric.set_params(**{key: value for key, value in parameters.items() if key in metric.get_params()})


def with_either_wrap(names):
    """Return the metrics of some names, those that may wrap angles twice: with it and without."""
    both = [metric_of(name, wrap=wrap) for name in names for wrap in (True, False)]
    return [metric for i, metric in enumerate(both) if metric not in both[:i]]


SKELETONS = {
    "chain": Skeleton.chain(4),
    "asf": load_asf(DATA / "arm.asf"),
    "bvh": load_bvh(DATA / "biped.bvh", scale=0.01).skeleton,
    "humanoid": humanoid(),
    "tree": random_tree(0),
    "tree, offsets in the parent's frame": random_tree(1, offset_frame="parent"),
    "ball joints": random_tree(2, kinds=["rotvec"]),
    "mixed joints": random_tree(3, kinds=MIXED, offset_frame="parent"),
    "weights": weighted(random_tree(4, n=12, kinds=MIXED), 0),
}


ALL_SKELETONS = ["humanoid", "mixed joints", "weights"]  # of the fixture


def in_turns(*values):
    """Combinations for `parametrize` in which every value occurs, as many as the longest list has."""
    n = max(map(len, values))
    return [pytest.param(*(some[i % len(some)] for some in values)) for i in range(n)]


def quick_on(*names):
    """Run a test with the fixture `skeleton` on these skeletons only."""
    return pytest.mark.parametrize("skeleton", names, indirect=True)


@pytest.fixture(params=ALL_SKELETONS, scope="session")
def skeleton(request):
    return SKELETONS[request.param]


@pytest.fixture
def poses(skeleton):
    """Ten poses of the skeleton, two of them equal."""
    X = np.random.default_rng(0).uniform(-3, 3, size=(10, skeleton.n_dofs))
    X[7] = X[2]
    return X


class ChainMixin:
    """Mixin that gives an estimator of poses or motions a planar chain as wide as X, for scikit-learn's checks."""

    def _check_X(self, X, *, reset, **options):
        X = super()._check_X(X, reset=reset, **options)
        if reset:
            super()._learn_metric(Skeleton.chain(self.n_features_in_))
        return X

    def _learn_metric(self, skeleton):
        """Wait for the width of X."""
        self.skeleton_, self.metric_ = None, Angle()


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """Chromium without a window; where there is none the test is skipped."""
    from browser import Browser

    one = Browser(tmp_path_factory.mktemp("pages"))
    yield one
    one.close()
