"""The scores of skpose.metrics against those of public repositories, on the same random numbers.

    python benchmarks/scores.py [FOLDER] [--quick]

FOLDER has clones of the repositories, each in a folder of its name ("VIBE", "mmpose"); those that are not there are
left out. Of a file only the functions that compute a score are taken, so that nothing else of a repository has to be
installed; torch, cv2 and fastdtw are used where they are installed, and what needs them is left out otherwise. The
table says, for each file, which score of skpose it is, and the largest difference in the unit of the score. Above 1e-9
it is an error; files that compute in float32, add a small number or integrate numerically are marked, and may differ by
1e-3.

Without FOLDER the numbers are those of `tests/metrics/score_conventions.py`, which was written anew from what the files
compute. Then times: 100,000 frames of 17 joints.
"""

import __future__

import ast
import importlib
import sys
import time
import types
import warnings
from pathlib import Path

import common
import numpy as np
from scipy.linalg import orthogonal_procrustes
from scipy.spatial.distance import euclidean
from scipy.spatial.transform import Rotation

from skpose.metrics import pose_score

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "metrics"))
from score_conventions import N_JOINTS, Data, checks

EXACT, ROUNDED = 1e-9, 1e-3  # largest difference: in float64, and of what rounds on its own
HIPS = (2, 3)
FOLDERS = {  # repository, where the clone's name is not unique
    "mmpose": "open-mmlab/mmpose",
    "mmhuman3d": "open-mmlab/mmhuman3d",
    "VIBE": "mkocabas/VIBE",
    "TCMR_RELEASE": "hongsukchoi/TCMR_RELEASE",
    "SPIN": "nkolot/SPIN",
    "hmr": "akanazawa/hmr",
    "tram": "yufu-wang/tram",
    "WHAM": "yohanshin/WHAM",
    "GVHMR": "zju3dv/GVHMR",
    "GAST-Net-3DPoseEstimation": "fabro66/GAST-Net-3DPoseEstimation",
    "MixSTE": "JinluZhang1126/MixSTE",
    "SemGCN": "garyzhao/SemGCN",
    "PoseAug": "jfzhang95/PoseAug",
    "3DMPPE_POSENET_RELEASE": "mks0601/3DMPPE_POSENET_RELEASE",
    "expose": "vchoutas/expose",
    "ROMP": "Arthur151/ROMP",
    "freihand": "lmb-freiburg/freihand",
    "hand3d": "lmb-freiburg/hand3d",
    "motion-transformer": "eth-ait/motion-transformer",
    "fairmotion": "facebookresearch/fairmotion",
    "human-motion-prediction": "una-dinosauria/human-motion-prediction",
    "STSGCN": "FraLuca/STSGCN",
    "RotationContinuity": "papagina/RotationContinuity",
    "pytorch3d": "facebookresearch/pytorch3d",
    "neural_temporal_models": "cr7anand/neural_temporal_models",
    "ubisoft-laforge-animation-dataset": "ubisoft/ubisoft-laforge-animation-dataset",
    "motion_inbetweening": "victorqin/motion_inbetweening",
    "delta-interpolator": "boreshkinai/delta-interpolator",
    "ProgressiveTransformersSLP": "BenSaunders27/ProgressiveTransformersSLP",
    "SLRTP-Sign-Production-Evaluation": "walsharry/SLRTP-Sign-Production-Evaluation",
    "Ham2Pose": "rotem-shalev/Ham2Pose",
    "SOKE": "ronggong000/SOKE",
}


class Missing(Exception):
    """A file or a package that is not there."""


def installed(name):
    """Return a module that is not a part of this project."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise Missing(f"{name} is not installed") from None


class Public:
    """The functions of a file of a repository."""

    def __init__(self, folder, repository, path):
        self.file = folder / repository / path
        if not self.file.exists():
            raise Missing(f"{repository}/{path} is not there")

    def take(self, *names, cuda=False, **given):
        """Return functions, classes and constants of the file by their names; what they use of others is `given`."""
        text = self.file.read_text(encoding="utf-8")
        if not cuda:
            text = text.replace(".cuda()", "")
        space = {"np": np, **given}
        flags = __future__.annotations.compiler_flag
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of their syntax
            for node in ast.parse(text).body:
                targets = [getattr(one, "id", "") for one in getattr(node, "targets", [])]
                if {getattr(node, "name", ""), *targets} & {*names}:
                    exec(compile(ast.Module([node], []), str(self.file), "exec", flags), space)
        return types.SimpleNamespace(**{name: space[name] for name in names})

    def statements(self, *targets):
        """Return the first assignments to some names, in the order of the file, in any block of it."""
        nodes = [
            node for node in ast.walk(ast.parse(self.file.read_text(encoding="utf-8"))) if isinstance(node, ast.Assign)
        ]
        nodes = sorted(
            (node for node in nodes if getattr(node.targets[0], "id", "") in targets), key=lambda n: n.lineno
        )
        return compile(ast.Module(nodes, []), str(self.file), "exec")


# Each check has the data and the files, and yields signatures, y_true, y_pred and the number of the file.


def of_mmpose(data, public, factor, pck=None):
    file = public("mmpose/core/evaluation/pose3d_eval.py" if pck is None else "mmhuman3d/core/evaluation/eval_utils.py")
    mesh = public(str(file.file.relative_to(file.file.parents[3]).parent / "mesh_eval.py"))
    given = vars(mesh.take("compute_similarity_transform"))
    names = ("keypoint_mpjpe", "keypoint_3d_pck", "keypoint_3d_auc")
    file = file.take(*names, **given)
    for alignment, prefix in (("none", ""), ("scale", "N-"), ("procrustes", "PA-")):
        p = data.pred if alignment == "none" else data.moved
        whole = np.ones_like(data.seen)
        yield f"{prefix}MPJPE|mm", data.true, p, 1e3 * file.keypoint_mpjpe(p, data.true, whole, alignment)
        if alignment == "none":  # theirs aligns joints that are not seen too
            yield "MPJPE|mm", data.unseen(), p, 1e3 * file.keypoint_mpjpe(p, data.true, data.seen, alignment)
        scaled = p * factor, data.true * factor
        yield f"{prefix}PCK|%", data.true, p, Rounded(file.keypoint_3d_pck(*scaled, whole, alignment))  # float32
        yield f"{prefix}PCK-AUC|%", data.true, p, Rounded(file.keypoint_3d_auc(*scaled, whole, alignment))


def mmpose_keypoints(data, public):
    given = vars(public("mmpose/evaluation/functional/keypoint_eval.py").take("_calc_distances", "_distance_acc"))
    names = ("keypoint_pck_accuracy", "keypoint_auc")
    space = public("mmpose/evaluation/functional/keypoint_eval.py").take(*given, *names, Tuple=tuple)
    factor = np.ones((len(data.true), 3))
    theirs = 100 * space.keypoint_pck_accuracy(data.pred, data.true, data.seen, 0.1, factor)[1]
    yield "PCK|%|100mm|average=joints", data.unseen(), data.pred, theirs


def mesh_recovery(data, public, path, hips=HIPS):
    file = public(path).take("compute_similarity_transform", "align_by_pelvis", "compute_errors")
    errors, aligned = file.compute_errors(data.true, data.moved)
    yield f"MPJPE|mm|root={hips[0]},{hips[1]}", data.true, data.moved, 1e3 * np.mean(errors)
    yield f"PA-MPJPE|mm|root={hips[0]},{hips[1]}", data.true, data.moved, 1e3 * np.mean(aligned)


def acceleration(data, public, path, name="compute_error_accel"):
    error = vars(public(path).take(name))[name]
    yield "Accel|mm", data.true, data.pred, 1e3 * np.mean(error(data.true, data.pred))
    known = np.where(data.frames[:, None, None], data.true, np.nan)
    yield "Accel|mm", known, data.pred, 1e3 * np.mean(error(data.true, data.pred, data.frames))


def spin(data, public):
    names = ("compute_similarity_transform", "compute_similarity_transform_batch", "reconstruction_error")
    error = public("utils/pose_utils.py").take(*names).reconstruction_error
    yield "PA-MPJPE|mm|scale", data.true, data.moved, 1e3 * error(data.moved, data.true)


def gvhmr(data, public):
    torch = installed("torch")
    names = ("batch_align_by_pelvis", "compute_jpe", "batch_compute_similarity_transform_torch")
    file = public("hmr4d/utils/eval/eval_utils.py").take(*names, "compute_error_accel", torch=torch)
    true, pred = torch.from_numpy(data.true), torch.from_numpy(data.moved)
    near = torch.from_numpy(data.pred)
    pelvis = file.batch_align_by_pelvis([pred, true, pred, true], [1, 2])
    yield "MPJPE|mm|root=1,2", data.true, data.moved, 1e3 * np.mean(file.compute_jpe(*pelvis[:2]))
    yield "Accel|m/s²|frame_rate=30", data.true, data.pred, np.mean(file.compute_error_accel(true, near, fps=30))


def batched(data, public, path):
    torch = installed("torch")
    file = public(path).take("batch_compute_similarity_transform_torch", torch=torch)
    default = torch.get_default_dtype()
    torch.set_default_dtype(torch.float64)  # of torch.eye
    try:
        moved = file.batch_compute_similarity_transform_torch(torch.from_numpy(data.moved), torch.from_numpy(data.true))
    finally:
        torch.set_default_dtype(default)
    theirs = 1e3 * np.linalg.norm(moved.numpy() - data.true, axis=2).mean()
    yield "PA-MPJPE|mm|scale", data.true, data.moved, theirs


def point_clouds(data, public, path):
    torch = installed("torch")
    file = public(path).take("align_pcl", torch=torch)
    true, pred = torch.from_numpy(data.true), torch.from_numpy(data.moved)
    default = torch.get_default_dtype()
    torch.set_default_dtype(torch.float64)
    try:
        for fixed, word in ((False, "scale"), (True, "rigid")):
            s, R, t = (one.numpy() for one in file.align_pcl(true, pred, fixed_scale=fixed))
            moved = s[:, None] * np.einsum("tij,tnj->tni", R, data.moved) + t[:, None]
            yield f"PA-MPJPE|mm|{word}", data.true, data.moved, 1e3 * np.linalg.norm(moved - data.true, axis=2).mean()
    finally:
        torch.set_default_dtype(default)


def video_pose(data, public, path, extra=()):
    torch = installed("torch")
    file = public(path).take("mpjpe", "p_mpjpe", *extra, torch=torch)
    tensors = torch.from_numpy(data.moved), torch.from_numpy(data.true)
    yield "MPJPE|mm", data.true, data.moved, 1e3 * float(file.mpjpe(*tensors))
    yield "PA-MPJPE|mm|scale", data.true, data.moved, 1e3 * file.p_mpjpe(data.moved.copy(), data.true.copy())
    if "n_mpjpe" in extra:
        yield "N-MPJPE|mm", data.true, data.moved, 1e3 * float(file.n_mpjpe(*(one[None] for one in tensors)))


def pose_aug(data, public):
    file = public("utils/loss.py").take("procrustes", "compute_PCK", "compute_AUC")
    for scaling, word in ((True, "scale"), (False, "rigid")):
        for reflection, more in ((False, ""), ("best", "|reflection")):
            pairs = zip(data.true, data.moved, strict=True)
            moved = np.stack([file.procrustes(t.copy(), p.copy(), scaling, reflection)[1] for t, p in pairs])
            theirs = 1e3 * np.linalg.norm(moved - data.true, axis=2).mean()
            yield f"PA-MPJPE|mm|{word}{more}", data.true, data.moved, theirs
    yield "PCK|%|150mm", data.true, data.pred, file.compute_PCK(data.true, data.pred)
    yield "PCK-AUC|%", data.true, data.pred, file.compute_AUC(data.true, data.pred)


def rigid(data, public):
    file = public("common/utils/pose_utils.py").take("rigid_transform_3D", "rigid_align")
    moved = np.stack([file.rigid_align(p, t) for t, p in zip(data.true, data.moved, strict=True)])
    yield "PA-MPJPE|mm|rigid", data.true, data.moved, 1e3 * np.linalg.norm(moved - data.true, axis=2).mean()


def expose(data, public):
    file = public("expose/utils/metrics.py").take("mpjpe", "ProcrustesAlignment", "RootAlignmentMPJPE")
    pairs = list(zip(data.true, data.moved, strict=True))
    moved = np.stack([file.ProcrustesAlignment()(p, t) for t, p in pairs])
    yield "PA-MPJPE|mm|scale", data.true, data.moved, 1e3 * file.mpjpe(moved, data.true).mean()
    root = np.mean([file.RootAlignmentMPJPE(5)(t, p)["point"] for t, p in pairs])
    yield "MPJPE|mm|root=5", data.true, data.moved, 1e3 * root


def romp(data, public):
    public = public("romp/lib/evaluation/pw3d_eval/evaluate.py")
    constants = vars(public.take("SMPL_MAJOR_JOINTS", "SMPL_OR_JOINTS", "SMPL_NR_JOINTS"))
    names = ("compute_auc", "compute_pck", "compute_similarity_transform", "align_by_root", "compute_errors")
    file = public.take(*constants, *names)
    mpjpe, aligned, errors, _ = file.compute_errors(1e3 * data.pred, 1e3 * data.true)
    yield "MPJPE|mm|root=0", data.true, data.pred, mpjpe
    yield "PA-MPJPE|mm|scale|root=0", data.true, data.pred, aligned
    joints = "joints=" + ",".join(map(str, constants["SMPL_MAJOR_JOINTS"]))
    yield f"PCK|%|50mm|inclusive|root=0|{joints}", data.true, data.pred, 100 * file.compute_pck(errors, 50.0)
    limits = np.arange(0.0, 200.0)
    curve = [file.compute_pck(errors, limit) for limit in limits]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # scipy.integrate.quad, of its accuracy
        area = 100 * file.compute_auc(limits / limits.max(), curve)
    text = f"PCK-AUC|%|199mm|n_thresholds=200|rule=trapezoid|inclusive|root=0|{joints}"
    yield text, data.true, data.pred, Rounded(area)
    angles = public.take("SMPL_OR_JOINTS", "joint_angle_error", cv2=installed("cv2")).joint_angle_error
    true, pred = data.rotations
    chosen = constants["SMPL_OR_JOINTS"]
    yield "Geodesic|deg", true[:, chosen], pred[:, chosen], np.degrees(angles(pred[:, chosen], true))


def hand3d(data, public):
    np_ = types.SimpleNamespace(**{**vars(np), "trapz": np.trapezoid})
    util = public("utils/general.py").take("EvalUtil", np=np_).EvalUtil(N_JOINTS)
    for true, seen, pred in zip(data.true, data.seen, data.pred, strict=True):
        util.feed(true, seen, pred)
    mean, _, area, _, _ = util.get_measures(0.0, 0.2, 100)
    yield "MPJPE|mm|average=joints", data.unseen(), data.pred, 1e3 * mean
    text = "PCK-AUC|%|200mm|n_thresholds=100|rule=trapezoid|inclusive|average=joints"
    yield text, data.unseen(), data.pred, 100 * area


def freihand(data, public):
    align = public("eval.py").take("align_w_scale", orthogonal_procrustes=orthogonal_procrustes).align_w_scale
    moved = np.stack([align(t.copy(), p.copy()) for t, p in zip(data.true, data.moved, strict=True)])
    theirs = 1e3 * np.linalg.norm(moved - data.true, axis=2).mean()
    yield "PA-MPJPE|mm|scale|reflection", data.true, data.moved, Rounded(theirs)  # adds 1e-8 to sizes


def euler(rotations):
    return Rotation.from_matrix(rotations).as_euler("xyz")


def structured_prediction(data, public):
    given = {"rotmat2euler": euler, "cv2": installed("cv2")}
    file = public("metrics/motion_metrics.py").take("pck", "angle_diff", "euler_diff", **given)
    true, pred = data.rotations
    angles = [euler(one.reshape(-1, 3, 3)).reshape(len(one), -1) for one in (true, pred)]
    yield "PCK|%|100mm|inclusive", data.true, data.pred, Rounded(100 * np.mean(file.pck(data.pred, data.true, 0.1)))
    yield "Geodesic|rad", true, pred, np.mean(file.angle_diff(pred, true))
    yield "Angle|rad|norm|wrap=False|drop_constant=true", *angles, np.mean(file.euler_diff(pred, true))


def fairmotion(data, public):
    conversions = types.SimpleNamespace(R2E=euler)
    file = public("fairmotion/tasks/motion_prediction/metrics.py").take("euler_diff", conversions=conversions)
    true, pred = data.rotations
    angles = [euler(one.reshape(-1, 3, 3)).reshape(len(one), -1) for one in (true, pred)]
    yield "Angle|rad|norm|wrap=False|drop_constant=true", *angles, np.mean(file.euler_diff(pred, true))


def martinez(data, public):
    true, pred = data.angles.copy()
    space = {"np": np, "srnn_gts_euler": {"walk": [true]}, "action": "walk", "i": 0, "eulerchannels_pred": pred}
    exec(public("src/translate.py").statements("idx_to_use", "euc_error"), space)
    yield "Angle|rad|norm|wrap=False|drop_constant=pred", true, pred, np.mean(space["euc_error"])


def stsgcn(data, public):
    torch = installed("torch")
    same = types.SimpleNamespace(rotmat2euler_torch=lambda x: x, expmap2rotmat_torch=lambda x: x)
    file = public("utils/loss_funcs.py").take("euler_error", "mpjpe_error", torch=torch, data_utils=same)
    true, pred = (torch.from_numpy(one)[None] for one in data.angles)
    yield "Angle|rad|norm|wrap=False", *data.angles, float(file.euler_error(pred, true))
    tensors = torch.from_numpy(data.pred), torch.from_numpy(data.true)
    yield "MPJPE|mm", data.true, data.pred, 1e3 * float(file.mpjpe_error(*tensors))


def traces(data, public, path, name, degrees, extra=()):
    torch = installed("torch")
    angle = vars(public(path).take(name, *extra, torch=torch))[name]
    true, pred = (torch.from_numpy(one.reshape(-1, 3, 3)) for one in data.rotations)
    yield f"Geodesic|{'deg' if degrees else 'rad'}", *data.rotations, float(angle(pred, true).mean())


def spectra(data, public, path, name):
    error = vars(public(path).take(name))[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", np.exceptions.ComplexWarning)  # it drops the imaginary part
        yield "NPSS|spectrum=real", *data.motions, error(*data.motions)


def in_betweening(data, public):
    torch = installed("torch")
    error = public("packages/motion_inbetween/benchmark.py").take("get_npss_loss_batch").get_npss_loss_batch
    distances, powers = error(*map(torch.from_numpy, data.motions))
    yield "NPSS|spectrum=real", *data.motions, (distances * powers / powers.sum()).sum()


def delta(data, public):
    torch = installed("torch")

    class Metric:
        def __init__(self, **_):
            pass

        def add_state(self, name, default, dist_reduce_fx):
            setattr(self, name, list(default))

    metric = public("src/evaluation/npss_error.py").take("NPSS", torch=torch, Metric=Metric).NPSS()
    true, pred = map(torch.from_numpy, data.motions)
    metric.update(pred, true)
    yield "NPSS|spectrum=real", *data.motions, Rounded(float(metric.compute()))  # adds 1e-9 to powers


def progressive(data, public):
    torch = installed("torch")
    dtw = warping(public("dtw.py"))
    scores = public("helpers.py").take("calculate_dtw", torch=torch, dtw=dtw).calculate_dtw
    found = []
    for true, pred in data.pairs:  # a counter in the last column, which ends at its largest; a first frame to leave out
        flat = [np.hstack([one.reshape(len(one), -1), np.arange(len(one))[:, None]]) for one in (true, pred)]
        flat = [np.vstack([one, one[-1:] * 0]) for one in flat]
        true_, pred_ = torch.from_numpy(flat[0])[None], torch.from_numpy(np.vstack([flat[1][:1], flat[1]]))[None]
        found += scores(true_, pred_)
    cut = [(true[:-1], pred[:-1]) for true, pred in data.pairs]
    yield "DTW-MJE|mm|cost=l1|divide=true", *map(list, zip(*cut, strict=True)), 1e3 * np.mean(found)


def warping(file):
    constants = {
        "inf": np.inf,
        "isinf": np.isinf,
        "zeros": np.zeros,
        "full": np.full,
        "array": np.array,
        "argmin": np.argmin,
    }
    return file.take("dtw", "_traceback", **constants).dtw


def soke(data, public):
    file = public("mGPT/metrics/dtw.py")
    dtw, taken = warping(file), file.take("l2_dist", "l2_dist_align")
    true, pred = map(list, zip(*data.pairs, strict=True))
    for text, cost in (("", taken.l2_dist), ("|root=0", lambda x, y: taken.l2_dist_align(x, y, align_idx=0))):
        sums = [dtw(p, t, cost)[0] for t, p in data.pairs]
        yield f"DTW-MJE|mm|cost=joints|divide=None{text}", true, pred, 1e3 * np.mean(sums)


def exact(x, y, dist=None, **_):
    """Return the least sum, and a path of it, as fastdtw does, which for a radius of 1 finds a longer one."""
    return installed("fastdtw").dtw(np.asarray(x), np.asarray(y), dist=dist)


def slrtp(data, public):
    torch = installed("torch")
    installed("fastdtw")
    given = {"torch": torch, "tqdm": lambda rows, **_: rows, "dtw": exact}
    warnings.simplefilter("ignore")  # torch.tensor of a tensor
    file = public("metrics.py").take("mpjpe", "pose_dtw_mje", **given)
    true, pred = ([torch.from_numpy(pair[i]) for pair in data.pairs] for i in (0, 1))
    text = "DTW-MJE|mm|cost=norm|error=joints|divide=path|pool=True"
    yield text, *map(list, zip(*data.pairs, strict=True)), 1e3 * file.pose_dtw_mje(pred, true)


def ham2pose(data, public):
    installed("fastdtw")
    names = ("masked_euclidean", "get_idx2weight", "get_pose_data", "mse", "APE", "masked_mse", "compare_poses")
    compare = public("metrics.py").take(*names, fastdtw=exact, euclidean=euclidean).compare_poses
    rng = np.random.default_rng(0)
    true, pred = rng.normal(size=(8, 1, 137, 3)), rng.normal(size=(6, 1, 137, 3))
    poses = [types.SimpleNamespace(body=types.SimpleNamespace(data=np.ma.array(one))) for one in (pred, true)]
    joints = ",".join(map(str, [*range(9), *range(95, 137)]))
    yield (
        f"DTW-MJE|mm|cost=joints|divide=None|warp=joint|joints={joints}",
        true[:, 0],
        pred[:, 0],
        1e3 * compare(*poses),
    )


class Rounded(float):
    """A number of a file that rounds, or adds a small number."""


CHECKS = [
    ("mmpose", "mmpose/core/evaluation/pose3d_eval.py", lambda d, p: of_mmpose(d, p, 1.0)),
    ("mmpose", "mmpose/evaluation/functional/keypoint_eval.py", mmpose_keypoints),
    ("mmhuman3d", "mmhuman3d/core/evaluation/eval_utils.py", lambda d, p: of_mmpose(d, p, 1e3, True)),
    (
        "mmhuman3d",
        "mmhuman3d/core/evaluation/eval_utils.py",
        lambda d, p: acceleration(d, p, CHECKS[2][1], "keypoint_accel_error"),
    ),
    *(
        (name, path, lambda d, p, path=path: mesh_recovery(d, p, path))
        for name, path in (
            ("VIBE", "lib/utils/eval_utils.py"),
            ("TCMR_RELEASE", "lib/utils/eval_utils.py"),
            ("hmr", "src/benchmark/eval_util.py"),
            ("tram", "lib/utils/eval_utils.py"),
        )
    ),
    ("SPIN", "utils/pose_utils.py", spin),
    ("GVHMR", "hmr4d/utils/eval/eval_utils.py", gvhmr),
    *(
        (name, path, lambda d, p, path=path: batched(d, p, path))
        for name, path in (("VIBE", "lib/utils/eval_utils.py"), ("GVHMR", "hmr4d/utils/eval/eval_utils.py"))
    ),
    *(
        (name, path, lambda d, p, path=path: point_clouds(d, p, path))
        for name, path in (("WHAM", "lib/eval/eval_utils.py"), ("tram", "lib/utils/eval_utils.py"))
    ),
    ("GAST-Net-3DPoseEstimation", "common/loss.py", lambda d, p: video_pose(d, p, "common/loss.py")),
    ("MixSTE", "common/loss.py", lambda d, p: video_pose(d, p, "common/loss.py", ("n_mpjpe",))),
    ("SemGCN", "common/loss.py", lambda d, p: video_pose(d, p, "common/loss.py", ("n_mpjpe",))),
    ("PoseAug", "utils/loss.py", lambda d, p: video_pose(d, p, "utils/loss.py", ("n_mpjpe",))),
    ("PoseAug", "utils/loss.py", pose_aug),
    ("3DMPPE_POSENET_RELEASE", "common/utils/pose_utils.py", rigid),
    ("expose", "expose/utils/metrics.py", expose),
    ("ROMP", "romp/lib/evaluation/pw3d_eval/evaluate.py", romp),
    ("hand3d", "utils/general.py", hand3d),
    ("freihand", "eval.py", freihand),
    *(
        (name, path, lambda d, p, path=path: acceleration(d, p, path))
        for name, path in (
            ("VIBE", "lib/utils/eval_utils.py"),
            ("TCMR_RELEASE", "lib/utils/eval_utils.py"),
            ("WHAM", "lib/eval/eval_utils.py"),
            ("tram", "lib/utils/eval_utils.py"),
        )
    ),
    ("motion-transformer", "metrics/motion_metrics.py", structured_prediction),
    ("fairmotion", "fairmotion/tasks/motion_prediction/metrics.py", fairmotion),
    ("human-motion-prediction", "src/translate.py", martinez),
    ("STSGCN", "utils/loss_funcs.py", stsgcn),
    *(
        (name, path, lambda d, p, a=(path, function, degrees, more): traces(d, p, *a))
        for name, path, function, degrees, more in (
            (
                "RotationContinuity",
                "sanity_test/code/tools.py",
                "compute_geodesic_distance_from_two_matrices",
                False,
                (),
            ),
            ("pytorch3d", "pytorch3d/transforms/so3.py", "so3_relative_angle", False, ("so3_rotation_angle",)),
            ("tram", "lib/utils/eval_utils.py", "getAngle", True, ()),
        )
    ),
    ("neural_temporal_models", "metrics.py", lambda d, p: spectra(d, p, "metrics.py", "compute_metrics")),
    (
        "ubisoft-laforge-animation-dataset",
        "lafan1/benchmarks.py",
        lambda d, p: spectra(d, p, "lafan1/benchmarks.py", "fast_npss"),
    ),
    ("motion_inbetweening", "packages/motion_inbetween/benchmark.py", in_betweening),
    ("delta-interpolator", "src/evaluation/npss_error.py", delta),
    ("ProgressiveTransformersSLP", "helpers.py", progressive),
    ("SLRTP-Sign-Production-Evaluation", "metrics.py", slrtp),
    ("Ham2Pose", "metrics.py", ham2pose),
    ("SOKE", "mGPT/metrics/dtw.py", soke),
]


def compare(folder, n_frames):
    """Print the table of the files that are there; return how many differ."""
    rows, left_out, n_wrong = {}, {}, 0
    for seed in range(3):
        data = Data(n_frames, seed)
        for repository, path, check in CHECKS:
            try:
                for signature, true, pred, theirs in check(
                    data, lambda path, name=repository: Public(folder, name, path)
                ):
                    ours = pose_score(signature, true, pred)
                    key = (ours.signature.split("|joints=")[0], FOLDERS[repository], path)
                    gap = abs(float(ours) - float(theirs))
                    rows[key] = max(rows.get(key, (0.0, False)), (gap, isinstance(theirs, Rounded)))
            except Missing as error:
                left_out[repository, path] = str(error)
    print("| score | repository | path | largest difference |\n|---|---|---|---|")
    for (signature, repository, path), (gap, rounded) in sorted(rows.items()):
        is_wrong = gap > (ROUNDED if rounded else EXACT)
        n_wrong += is_wrong
        note = " (it rounds)" * rounded + " DIFFERS" * is_wrong
        print(f"| `{signature.replace('|', chr(92) + '|')}` | {repository} | {path} | {gap:.1g}{note} |")
    for (repository, path), why in left_out.items():
        print(f"left out: {FOLDERS[repository]} {path}: {why}")
    return n_wrong


def compare_conventions(n_frames):
    """Print the largest difference from the formulas that were written anew; return how many differ."""
    n_wrong, gaps = 0, {}
    for seed in range(3):
        for signature, name, true, pred, theirs in checks(Data(n_frames, seed)):
            gap = abs(float(pose_score(signature, true, pred)) - float(theirs))
            gaps[signature.split("|joints=")[0], name] = max(gap, gaps.get((signature.split("|joints=")[0], name), 0.0))
    for (signature, name), gap in sorted(gaps.items()):
        n_wrong += gap > EXACT
        print(f"{signature:64} {name:28} {gap:.1g}" + " DIFFERS" * (gap > EXACT))
    return n_wrong


def times(n_frames):
    """Print seconds for frames of 17 joints."""
    rng = np.random.default_rng(0)
    true = rng.normal(scale=0.3, size=(n_frames, 17, 3))
    pred = true + rng.normal(scale=0.05, size=true.shape)
    flat = true.reshape(n_frames, -1), pred.reshape(n_frames, -1)
    tasks = {
        "MPJPE|mm": (true, pred),
        "PA-MPJPE|mm|scale": (true, pred),
        "PCK|%": (true, pred),
        "PCK-AUC|%": (true, pred),
        "Accel|mm": (true, pred),
        "Geodesic|deg|form=rotvec": (true, pred),
        "Angle|rad": flat,
        "NPSS": [one.reshape(-1, 100, 51) for one in flat],
    }
    print(f"\nseconds for {n_frames:,} frames of 17 joints")
    for signature, (one, another) in tasks.items():
        seconds = []
        for _ in range(common.REPEATS):
            start = time.perf_counter()
            pose_score(signature, one, another)
            seconds.append(time.perf_counter() - start)
        print(f"{signature:28} {np.median(seconds):7.3f}")


def main():
    parser = common.parser(__doc__, folder=False)
    parser.add_argument("folder", nargs="?", type=Path, help="clones of the repositories")
    options = parser.parse_args()
    common.print_machine()
    n_frames = 20 if options.quick else 60
    n_wrong = compare_conventions(n_frames) if options.folder is None else compare(options.folder, n_frames)
    times(1_000 if options.quick else 100_000)
    if n_wrong:
        sys.exit(f"{n_wrong} scores differ")


if __name__ == "__main__":
    main()
