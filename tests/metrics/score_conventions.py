"""Scores a second time: what papers and public programs compute, written anew, slowly and by the definition.

Nothing here is shared with `skpose`. Rotations and Procrustes alignment are scipy's, loops go over frames and joints.
"""

import numpy as np
from scipy.linalg import orthogonal_procrustes
from scipy.spatial.transform import Rotation
from scipy.stats import wasserstein_distance

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
    """Yield signatures, who computes it, truth, prediction, and the number."""
    yield from position_checks(data)
    yield from motion_checks(data)
    yield from angle_checks(data)


def position_checks(data):
    true, pred, moved, gaps = data.true, data.pred, data.moved, distances(data.true, data.pred)
    yield "MPJPE|mm", "VideoPose3D's loss", true, pred, 1e3 * gaps.mean()
    yield "MPJPE|mm", "mmpose, mask", data.unseen(), pred, 1e3 * gaps[data.seen].mean()
    frames = [gap[seen].mean() for gap, seen in zip(gaps, data.seen, strict=True)]
    yield "MPJPE|mm|average=frames", "ROMP, by sample", data.unseen(), pred, 1e3 * np.mean(frames)
    joints = [gap[seen].mean() for gap, seen in zip(gaps.T, data.seen.T, strict=True)]
    yield "MPJPE|mm|average=joints", "hand3d", data.unseen(), pred, 1e3 * np.mean(joints)
    for root, who in (((0,), "3DPW"), ((2, 3), "hmr, VIBE, TCMR"), ((1, 2), "GVHMR, WHAM")):
        of_root = distances(relative(true, root), relative(pred, root))
        yield f"MPJPE|mm|root={','.join(map(str, root))}", who, true, pred, 1e3 * of_root.mean()
    yield "N-MPJPE|mm", "VideoPose3D's loss", true, moved, 1e3 * distances(true, scaled(true, moved)).mean()
    for word, with_scale in (("scale", True), ("rigid", False)):
        for more, reflection in (("", False), ("|reflection", True)):
            theirs = 1e3 * distances(true, aligned(true, moved, with_scale, reflection)).mean()
            who = "PoseAug, freihand" if reflection else "hmr, SPIN, VIBE, mmpose" if with_scale else "3DMPPE, WHAM"
            yield f"PA-MPJPE|mm|{word}{more}", who, true, moved, theirs
    yield "PCK|%|150mm", "MPI-INF-3DHP, mmpose", true, pred, 100 * share(gaps, 0.15)
    yield "PA-PCK|%|50mm|scale", "mmpose", true, moved, 100 * share(distances(true, aligned(true, moved, True)), 0.05)
    of_major = distances(relative(true, (0,)), relative(pred, (0,)))[:, MAJOR]
    major = f"root=0|joints={','.join(map(str, MAJOR))}"
    yield f"PCK|%|50mm|inclusive|{major}", "3DPW", true, pred, 100 * share(of_major, 0.05, True)
    by_joint = [share(gap[seen], 0.1) for gap, seen in zip(gaps.T, data.seen.T, strict=True)]
    yield "PCK|%|100mm|average=joints", "mmpose, keypoints", data.unseen(), pred, 100 * np.mean(by_joint)
    curve = [100 * share(gaps, limit) for limit in np.linspace(0, 0.15, 31)]
    yield "PCK-AUC|%", "MPI-INF-3DHP, mmpose", true, pred, np.mean(curve)
    limits = np.arange(200.0)
    curve = [100 * share(of_major, limit / 1e3, True) for limit in limits]
    text = f"PCK-AUC|%|199mm|n_thresholds=200|rule=trapezoid|inclusive|{major}"
    yield text, "3DPW", true, pred, np.trapezoid(curve, limits / limits[-1])


def motion_checks(data):
    true, pred, known = data.true, data.pred, np.ones(len(data.true), dtype=bool)
    yield "Accel|mm", "human_dynamics, VIBE", true, pred, 1e3 * accelerations(true, pred, known).mean()
    unknown = np.where(data.frames[:, None, None], true, np.nan)
    yield "Accel|mm", "VIBE, vis", unknown, pred, 1e3 * accelerations(true, pred, data.frames).mean()
    yield "Accel|m/s²|frame_rate=30", "GVHMR", true, pred, 900 * accelerations(true, pred, known).mean()
    for of, who in (("power", "Gopalakrishnan et al."), ("real", "their program, LAFAN1")):
        yield f"NPSS|spectrum={of}", who, *data.motions, npss(*data.motions, of)
    lists = [list(one) for one in zip(*data.pairs, strict=True)]
    found = [warp(t, p, lambda a, b: np.abs(a - b).sum()) for t, p in data.pairs]
    l1 = np.mean([total / len(t) for (total, _), (t, _) in zip(found, data.pairs, strict=True)])
    yield "DTW-MJE|mm|cost=l1|divide=true", "Saunders et al.", *lists, 1e3 * l1
    found = [warp(t, p, joint_error) for t, p in data.pairs]
    yield "DTW-MJE|mm|cost=joints|divide=None", "SOKE", *lists, 1e3 * np.mean([total for total, _ in found])
    means = [total / len(path) for total, path in found]
    yield "DTW-MJE|mm|cost=joints|divide=path", "by default", *lists, 1e3 * np.mean(means)
    found = [warp(t, p, lambda a, b: np.linalg.norm(a - b)) for t, p in data.pairs]
    pooled = [joint_error(t[i], p[j]) for (_, path), (t, p) in zip(found, data.pairs, strict=True) for i, j in path]
    yield "DTW-MJE|mm|cost=norm|error=joints|divide=path|pool=True", "SLRTP", *lists, 1e3 * np.mean(pooled)
    of_joint = [np.mean([warp(t[:, [j]], p[:, [j]], joint_error)[0] for j in range(t.shape[1])]) for t, p in data.pairs]
    yield "DTW-MJE|mm|cost=joints|divide=None|warp=joint", "Ham2Pose", *lists, 1e3 * np.mean(of_joint)
    true, pred = (relative(one[:4], (0,)) for one in (data.true, data.moved))
    total, path = warp(true, pred, lambda a, b: joint_error(a, aligned([a], [b], True)[0]))
    yield "PA-DTW-MJE|mm|scale|cost=joints|divide=path", "SOKE, DTW-PA-JPE", true, pred, 1e3 * total / len(path)


def angle_checks(data):
    true, pred = data.angles
    gaps = true - pred
    text = "Angle|rad|norm|wrap=False"
    yield text, "LearnTrajDep, STSGCN", true, pred, np.mean([np.sqrt(sum(gap**2)) for gap in gaps])
    for of, angles, who in (("true", true, "SPL, fairmotion"), ("pred", pred, "Martinez et al.")):
        moving = [k for k in range(angles.shape[1]) if angles[:, k].std() > 1e-4]
        yield f"{text}|drop_constant={of}", who, true, pred, np.mean([np.sqrt(sum(gap[moving] ** 2)) for gap in gaps])
    wrapped = [abs((gap + np.pi) % (2 * np.pi) - np.pi) for gap in gaps.ravel()]
    yield "Angle|deg|each|wrap=True", "Human3.6M, MPJAE", true, pred, np.degrees(np.mean(wrapped))
    true, pred = data.rotations
    each = [angle_between(a, b) for a, b in zip(true.reshape(-1, 3, 3), pred.reshape(-1, 3, 3), strict=True)]
    yield "Geodesic|rad", "RotationContinuity, SPL", true, pred, np.mean(each)
    yield "Geodesic|deg", "3DPW, MPJAE", true, pred, np.degrees(np.mean(each))
