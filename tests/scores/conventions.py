"""What papers and public programs compute, by the definition, with loops over frames and joints.

Only the names of the scores are from `skpose`; rotations and Procrustes alignment are from scipy.
"""

import numpy as np
from scipy.linalg import orthogonal_procrustes
from scipy.spatial.transform import Rotation
from scipy.stats import wasserstein_distance

from skpose import scores

N_JOINTS = 24
MAJOR = (1, 2, 4, 5, 7, 8, 16, 17, 18, 19, 20, 21)  # joints of SMPL that 3DPW counts


class Data:
    """Random truth and prediction of every kind; some of the predicted frames are rotated, scaled and mirrored."""

    def __init__(self, n_frames, seed):
        rng = np.random.default_rng(seed)
        self.true = rng.normal(scale=0.3, size=(n_frames, N_JOINTS, 3))  # m
        self.pred = self.true + rng.normal(scale=0.05, size=self.true.shape)
        rotations = Rotation.random(n_frames, rng=rng).as_matrix()
        sizes = rng.uniform(0.5, 2, n_frames) * np.where(rng.uniform(size=n_frames) < 0.2, -1.0, 1.0)
        self.moved = sizes[:, None, None] * np.einsum("fij,fnj->fni", rotations, self.pred)
        self.moved += rng.normal(size=(n_frames, 1, 3))
        self.seen = rng.uniform(size=self.true.shape[:2]) < 0.8
        self.frames = rng.uniform(size=n_frames) < 0.9
        matrices = Rotation.random(2 * n_frames * N_JOINTS, rng=rng).as_matrix()
        self.rotations = matrices.reshape(2, n_frames, N_JOINTS, 3, 3)
        self.angles = rng.uniform(-np.pi, np.pi, size=(2, n_frames, 99))
        self.angles[:, :, [7, 20]] = 0.3  # constant in both
        self.motions = rng.normal(size=(2, 5, 40, 12)) + rng.normal(size=(2, 5, 1, 12))
        sizes = ((9, 14), (12, 12), (20, 11))
        self.pairs = [(rng.normal(size=(n, 7, 3)), rng.normal(size=(m, 7, 3))) for n, m in sizes]

    def unseen(self):
        """Return the truth with NaN for joints that are not seen."""
        return np.where(self.seen[:, :, None], self.true, np.nan)


def distances(true, pred):
    """Return the distances (n_frames, n_joints) of joints."""
    return np.array(
        [[np.linalg.norm(p - t) for t, p in zip(*pair, strict=True)] for pair in zip(true, pred, strict=True)]
    )


def relative(positions, root):
    """Return positions relative to the middle of some joints."""
    return np.array([frame - np.mean([frame[j] for j in root], axis=0) for frame in positions])


def aligned(true, pred, with_scale, reflection=False):
    """Return each predicted frame moved to the true one."""
    found = []
    for t, p in zip(true, pred, strict=True):
        a, b = t - t.mean(axis=0), p - p.mean(axis=0)
        rotated = b @ orthogonal_procrustes(b, a)[0] if reflection else Rotation.align_vectors(a, b)[0].apply(b)
        scale = (rotated * a).sum() / (b * b).sum() if with_scale else 1.0
        found.append(scale * rotated + t.mean(axis=0))
    return np.array(found)


def scaled(true, pred):
    """Return each predicted frame times the scale of least squares about the origin."""
    return np.array(
        [p * np.linalg.lstsq(p.reshape(-1, 1), t.ravel(), rcond=None)[0] for t, p in zip(true, pred, strict=True)]
    )


def share(gaps, limit, inclusive=False):
    return np.mean([gap <= limit if inclusive else gap < limit for gap in np.ravel(gaps)])


def accelerations(true, pred, known):
    """Return the lengths of the differences of accelerations, of frames that are known with those next to them."""
    found = []
    for f in range(1, len(true) - 1):
        if known[f - 1 : f + 2].all():
            second = [x[f - 1] - 2 * x[f] + x[f + 1] for x in (true, pred)]
            found.append(np.linalg.norm(second[1] - second[0], axis=1))
    return np.array(found)


def spectrum(series, of):
    """Return a spectrum by the definition of the discrete Fourier transform."""
    n = np.arange(len(series))
    coefficients = np.exp(-2j * np.pi * np.outer(n, n) / len(n)) @ series
    return coefficients.real**2 if of == "real" else np.abs(coefficients) ** 2


def npss(true, pred, of):
    """Return the weighted mean of Wasserstein distances of spectra, in frequency bins."""
    gaps, powers = [], []
    for t, p in zip(true, pred, strict=True):
        for k in range(t.shape[1]):
            one, another = spectrum(t[:, k], of), spectrum(p[:, k], of)
            bins = np.arange(len(one))
            gaps.append(wasserstein_distance(bins, bins, one, another))
            powers.append(one.sum())
    return np.average(gaps, weights=powers)


def warp(true, pred, cost):
    """Return the least sum of costs of a monotone path, and the path, by recursion from the last frames."""
    costs = np.array([[cost(t, p) for p in pred] for t in true])
    best = {}
    for i in range(len(true)):
        for j in range(len(pred)):
            before = [best[k] for k in ((i - 1, j - 1), (i - 1, j), (i, j - 1)) if k in best]
            total, path = min(before, key=lambda one: one[0], default=(0.0, ()))
            best[i, j] = total + costs[i, j], (*path, (i, j))
    return best[len(true) - 1, len(pred) - 1]


def joint_error(t, p):
    return np.mean([np.linalg.norm(a - b) for a, b in zip(t, p, strict=True)])


def angle_between(a, b):
    return (Rotation.from_matrix(a).inv() * Rotation.from_matrix(b)).magnitude()


def checks(data):
    """Yield who computes it, the score, its options, truth, prediction, and the number."""
    yield from position_checks(data)
    yield from motion_checks(data)
    yield from angle_checks(data)


def position_checks(data):
    true, pred, moved, gaps = data.true, data.pred, data.moved, distances(data.true, data.pred)
    yield "VideoPose3D's loss", scores.mpjpe, {}, true, pred, 1e3 * gaps.mean()
    yield "mmpose, mask", scores.mpjpe, {}, data.unseen(), pred, 1e3 * gaps[data.seen].mean()
    frames = [gap[seen].mean() for gap, seen in zip(gaps, data.seen, strict=True)]
    yield "ROMP, by sample", scores.mpjpe, {"average": "frames"}, data.unseen(), pred, 1e3 * np.mean(frames)
    joints = [gap[seen].mean() for gap, seen in zip(gaps.T, data.seen.T, strict=True)]
    yield "hand3d", scores.mpjpe, {"average": "joints"}, data.unseen(), pred, 1e3 * np.mean(joints)
    for root, who in (([0], "3DPW"), ([2, 3], "hmr, VIBE, TCMR")):
        of_root = distances(relative(true, root), relative(pred, root))
        yield who, scores.mpjpe, {"root": root}, true, pred, 1e3 * of_root.mean()
    yield "N-MPJPE", scores.mpjpe, {"align": "scale"}, true, moved, 1e3 * distances(true, scaled(true, moved)).mean()
    for align in ("similarity", "rigid"):
        for reflection in (False, True):
            theirs = 1e3 * distances(true, aligned(true, moved, align == "similarity", reflection)).mean()
            yield (
                f"PA-MPJPE {reflection}",
                scores.mpjpe,
                {"align": align, "reflection": reflection},
                true,
                moved,
                theirs,
            )
    yield "MPI-INF-3DHP, mmpose", scores.pck, {}, true, pred, 100 * share(gaps, 0.15)
    close = 100 * share(distances(true, aligned(true, moved, True)), 0.05)
    yield "mmpose", scores.pck, {"align": "similarity", "threshold": 50}, true, moved, close
    of_major = distances(relative(true, (0,)), relative(pred, (0,)))[:, MAJOR]
    major = {"root": 0, "joints": list(MAJOR), "inclusive": True}
    yield "3DPW", scores.pck, {"threshold": 50, **major}, true, pred, 100 * share(of_major, 0.05, True)
    by_joint = [share(gap[seen], 0.1) for gap, seen in zip(gaps.T, data.seen.T, strict=True)]
    options = {"threshold": 100, "average": "joints"}
    yield "mmpose, keypoints", scores.pck, options, data.unseen(), pred, 100 * np.mean(by_joint)
    curve = [100 * share(gaps, limit) for limit in np.linspace(0, 0.15, 31)]
    yield "MPI-INF-3DHP, mmpose", scores.pck_auc, {}, true, pred, np.mean(curve)
    limits = np.arange(200.0)
    curve = [100 * share(of_major, limit / 1e3, True) for limit in limits]
    options = {"threshold": 199, "n_thresholds": 200, "rule": "trapezoid", **major}
    yield "3DPW", scores.pck_auc, options, true, pred, np.trapezoid(curve, limits / limits[-1])


def motion_checks(data):
    true, pred, known = data.true, data.pred, np.ones(len(data.true), dtype=bool)
    score = scores.acceleration_error
    yield "human_dynamics, VIBE", score, {}, true, pred, 1e3 * accelerations(true, pred, known).mean()
    unknown = np.where(data.frames[:, None, None], true, np.nan)
    yield "VIBE, vis", score, {}, unknown, pred, 1e3 * accelerations(true, pred, data.frames).mean()
    yield "GVHMR", score, {"unit": "m", "frame_rate": 30}, true, pred, 900 * accelerations(true, pred, known).mean()
    for of in ("power", "real"):
        yield "Gopalakrishnan et al.", scores.npss, {"spectrum": of}, *data.motions, npss(*data.motions, of)
    lists, score = [list(one) for one in zip(*data.pairs, strict=True)], scores.dtw_mje
    found = [warp(t, p, lambda a, b: np.abs(a - b).sum()) for t, p in data.pairs]
    l1 = np.mean([total / len(t) for (total, _), (t, _) in zip(found, data.pairs, strict=True)])
    yield "Saunders et al.", score, {"cost": "l1", "divide": "true"}, *lists, 1e3 * l1
    found = [warp(t, p, joint_error) for t, p in data.pairs]
    yield "SOKE", score, {"divide": None}, *lists, 1e3 * np.mean([total for total, _ in found])
    yield "by default", score, {}, *lists, 1e3 * np.mean([total / len(path) for total, path in found])
    found = [warp(t, p, lambda a, b: np.linalg.norm(a - b)) for t, p in data.pairs]
    pooled = [joint_error(t[i], p[j]) for (_, path), (t, p) in zip(found, data.pairs, strict=True) for i, j in path]
    yield "SLRTP", score, {"cost": "norm", "error": "joints", "average": "pairs"}, *lists, 1e3 * np.mean(pooled)
    of_joint = [np.mean([warp(t[:, [j]], p[:, [j]], joint_error)[0] for j in range(t.shape[1])]) for t, p in data.pairs]
    yield "Ham2Pose", score, {"divide": None, "warp": "joint"}, *lists, 1e3 * np.mean(of_joint)
    true, pred = (relative(one[:4], (0,)) for one in (data.true, data.moved))
    total, path = warp(true, pred, lambda a, b: joint_error(a, aligned([a], [b], True)[0]))
    yield "SOKE, DTW-PA-JPE", score, {"align": "similarity"}, true, pred, 1e3 * total / len(path)


def angle_checks(data):
    (true, pred), score = data.angles, scores.mean_angle_error
    gaps, options = true - pred, {"kind": "norm", "wrap": False}
    yield "LearnTrajDep, STSGCN", score, options, true, pred, np.mean([np.sqrt(sum(gap**2)) for gap in gaps])
    for of, angles in (("true", true), ("pred", pred)):
        moving = [k for k in range(angles.shape[1]) if angles[:, k].std() > 1e-4]
        expected = np.mean([np.sqrt(sum(gap[moving] ** 2)) for gap in gaps])
        yield "Martinez et al.", score, {**options, "drop_constant": of}, true, pred, expected
    wrapped = [abs((gap + np.pi) % (2 * np.pi) - np.pi) for gap in gaps.ravel()]
    yield "Human3.6M, MPJAE", score, {"unit": "deg"}, true, pred, np.degrees(np.mean(wrapped))
    true, pred = data.rotations
    each = angle_between(true.reshape(-1, 3, 3), pred.reshape(-1, 3, 3))
    yield "RotationContinuity, SPL", scores.geodesic_error, {"unit": "rad"}, true, pred, np.mean(each)
