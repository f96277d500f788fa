"""The explorer: all poses of a collection of motions as points in the plane."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import count
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from sklearn.manifold import TSNE

from skpose._utils.validation import check_choice, check_kind
from skpose.datasets import MotionDataset
from skpose.kinematics import forward_kinematics
from skpose.manifold import SpatialMDS
from skpose.metrics import Metric, Spatial
from skpose.metrics._registry import METRICS, resolve
from skpose.neighbors import PoseKNeighborsTransformer
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._sides import sides
from skpose.view._page import Page, check_labels, page_of
from skpose.view._scene import ANGLE, AXES, pack, unpack, vertical_of
from skpose.view._shape import find_shape

MILLISECOND = 1e-3
EMBEDDINGS = ("mds", "tsne")
ALL, LANDMARKS = 2000, 1000  # of more poses than ALL only the distances to so many landmarks are computed
PERPLEXITY = 30  # of t-SNE
# Scripts that compute without a page, in the order of their dependencies.
NUMBERS = ("rotations.js", "kinematics.js", "distances.js")
ASSETS = (
    "page.css",
    "panels.css",
    "explorer.css",
    "sharing.html",
    "page.js",
    "figure.js",
    "shape.js",
    "gestures.js",
    "orbit.js",
    *NUMBERS,
    "poses.js",
    "pose_view.js",
    "scatter.js",
    "lasso.js",
    "labels.js",
    "small_figures.js",
    "marks.js",
    "comparison.js",
    "link.js",
    "gif.js",
    "record.js",
    "sheet.js",
    "texts.js",
    "explorer_link.js",
    "explorer.js",
)


def explorer(
    dataset: MotionDataset,
    *,
    metrics: Sequence[str | Metric] = ("spatial", "position", "rotation", "angle"),
    embeddings: Sequence[str] = ("mds",),
    frame_rate: float | None = 12.0,
    labels: Sequence[str] | None = None,
    title: str | None = None,
    n_jobs: int | None = None,
    verbose: int = 0,
) -> Page:
    """Make a page that shows all poses of some motions as points: near points are similar poses under a metric.

    A point under the pointer shows its pose, a click plays its motion from there. Two poses are compared by four
    distances, and the straight line between them is played. A lasso lists the motions inside.

    Parameters
    ----------
    dataset : MotionDataset
        The motions. Their subjects and actions, if known, are choices of colour.
    metrics : sequence of str or Metric, default=("spatial", "position", "rotation", "angle")
        The metrics whose embeddings are in the page, see `skpose.pose_distances`; the page starts with the first.
    embeddings : sequence of {"mds", "tsne"}, default=("mds",)
        How the plane follows from the distances under each metric: `SpatialMDS`, or scikit-learn's `TSNE` of the
        nearest neighbours. The page starts with the first.
    frame_rate : float, default=12.0
        Poses a second, Hz, see `Motion.resample`; None takes every frame.
    labels : sequence of str, default=None
        A name for each motion; None uses its subject, action and trial, as far as they are known.
    title : str, default=None
        Title of the page; None states how many poses and motions there are.
    n_jobs : int, default=None
        Threads for the distances, see `skpose.pose_distances`.
    verbose : int, default=0
        Whether to show progress.

    Returns
    -------
    Page
        In a notebook it shows itself; ``page.save("explore.html")`` writes it, ``page.open()`` shows it in the browser.

    Raises
    ------
    TypeError
        If `dataset` is not a `MotionDataset`.
    ValueError
        For fewer than two poses, unknown metrics and embeddings, another number of labels, and motions
        whose poses are not comparable, see `MotionDataset.poses`.

    See Also
    --------
    player : Motions that play side by side.
    skpose.manifold.SpatialMDS : The embedding.
    skpose.plot.MDSDisplay : An embedding with matplotlib.

    Notes
    -----
    The page shows ``dataset.poses(frame_rate)`` on the mean skeleton, without the root unless the dataset is
    ``dataset.with_root()``. The numbers of a pose are rounded to a 65,536th of a turn; ``page.note`` states the largest
    error of a joint.

    "mds" is `SpatialMDS` with two components; of more than 2,000 poses 1,000 are landmarks, so that the cost is one
    distance for each pose and landmark. "tsne" has perplexity 30 and starts from "mds"; distances between its groups
    mean nothing, so that the page shows no scale. The metric "geodesic" takes an hour for
    a million distances. 10,000 poses of 56 numbers make a page of some 1 MB.

    A small figure shows the pose in the middle of each group, and single poses as one zooms in. Points are smaller and
    paler where many overlap. Colours repeat after ten groups, with another form of the points.

    Examples
    --------
    >>> from skpose.datasets import make_gait
    >>> from skpose.view import explorer
    >>> page = explorer(make_gait(2, 1, random_state=0), metrics=["spatial"])
    >>> page.title
    '144 poses of 4 motions'
    """
    check_kind(dataset, MotionDataset, "dataset", "MotionDataset(motions) is one")
    names = check_labels(labels, _default_labels(dataset))
    skeleton, motions = _prepare_motions(dataset, frame_rate)
    numbers = skeleton_data(skeleton)  # which refuses slides
    for given, choices, name in ((metrics, METRICS, "metrics"), (embeddings, EMBEDDINGS, "embeddings")):
        for one in given or ("",):
            if isinstance(one, str):
                check_choice(name, one, tuple(choices))
    chosen, methods = dict.fromkeys(resolve(metric, skeleton) for metric in metrics), dict.fromkeys(embeddings)
    X = np.concatenate([motion.angles for motion in motions])
    packed = pack(X, ANGLE)
    positions = forward_kinematics(X, skeleton)
    errors = np.linalg.norm(forward_kinematics(unpack(packed), skeleton) - positions, axis=2)
    error = 1e3 * float(errors.max(initial=0.0))
    extents = positions.max(axis=1, initial=0.0) - positions.min(axis=1, initial=0.0)  # the root is at zero
    note = f"{len(X):,} poses of {len(motions)} motion{'s' * (len(motions) != 1)}"
    heading = note if title is None else title
    rates = {motion.frame_rate for motion in motions}
    data = {
        "title": heading,
        "rate": rates.pop() if len(rates) == 1 else None,
        "error": error,
        "metrics": [
            {"name": name, "unit": METRICS[name].unit} for name in ("angle", "position", "rotation", "spatial")
        ],
        "steps": Spatial().n_steps,
        "poses": packed,
        "skeleton": numbers,
        "size": float(np.median(extents.max(axis=1))) or 1.0,
        "up": _up(motions),
        **_motions_data(dataset, motions, names),
        "embeddings": _embed(X, skeleton, chosen, methods, n_jobs, verbose),
    }
    return page_of(heading, f"{note}, positions within {error:.2g} mm", data, "explorer.html", ASSETS)


def _default_labels(dataset: MotionDataset) -> list[str]:
    known = [getattr(dataset, name, None) for name in ("subjects", "actions", "trials")]
    parts = zip(*(values for values in known if values is not None), strict=True)
    named = [" · ".join(part for part in of_one if part) for of_one in parts] or [""] * len(dataset)
    named = [name or f"motion {i}" for i, name in enumerate(named, start=1)]
    counts = {name: count(1) for name, n in Counter(named).items() if n > 1}
    return [f"{name} ({next(counts[name])})" if name in counts else name for name in named]


def _prepare_motions(dataset: MotionDataset, frame_rate: float | None) -> tuple[Skeleton, list[Motion]]:
    """The mean skeleton, and the motions on it at the frame rate, as in `MotionDataset.poses`."""
    motions = list(dataset.retarget(dataset.skeleton, method="numbers")) if len(dataset) else []
    if frame_rate is not None:
        motions = [motion.resample(frame_rate) for motion in motions]
    if (n := sum(map(len, motions))) < 2:
        raise ValueError(f"dataset must have at least 2 poses at this frame_rate, got {n}")
    return dataset.skeleton, motions


def _up(motions: Sequence[Motion]) -> dict[str, Any]:
    """Axes of the root that are x, y and z in the page, y up in the mean of all frames, with signs and names."""
    total = np.sum([vertical_of(motion) for motion in motions if len(motion)], axis=0)
    axis = int(np.abs(total).argmax())
    signs = [1, 1, 1] if total[axis] >= 0.0 else [1, -1, -1]  # half a turn does not mirror
    order = AXES["xyz"[axis]]
    names = ["xyz"[a] if s > 0 else "" for a, s in zip(order, signs, strict=True)]
    return {"order": order, "signs": signs, "names": names}


def _with_numbers(name: str) -> tuple[list[str | int], str]:
    """A key that sorts names by the numbers in them: "2" before "10", and "01" before "1"."""
    return [int(part) if i % 2 else part for i, part in enumerate(re.split(r"(\d+)", name))], name


def _motions_data(dataset: MotionDataset, motions: Sequence[Motion], names: Sequence[str]) -> dict[str, Any]:
    """Data of each motion: its name, number of poses, their times, and its groups."""
    groups = []
    for word in ("subject", "action"):
        values = getattr(dataset, f"{word}s", None)
        if values is not None:
            found = sorted(set(values.tolist()), key=_with_numbers)
            groups.append({"by": word, "names": found, "of": [found.index(value) for value in values.tolist()]})
    times = np.concatenate([motion.times for motion in motions])
    return {
        "labels": names,
        "counts": [len(motion) for motion in motions],
        "times": pack(times[:, None], MILLISECOND),
        "groups": groups,
    }


def _embed(
    X: np.ndarray,
    skeleton: Skeleton,
    metrics: Iterable[Metric],
    methods: Iterable[str],
    n_jobs: int | None,
    verbose: int,
) -> list[dict[str, Any]]:
    """Data of each method and metric; all planes are flipped like the first."""
    found: list[dict[str, Any]] = []
    first = None
    for metric in metrics:
        scaling = SpatialMDS(
            skeleton,
            n_components=2,
            metric=metric,
            landmarks=LANDMARKS if len(X) > ALL else None,
            random_state=0,
            n_jobs=n_jobs,
            verbose=verbose,
        )
        scaled = scaling.fit_transform(X)
        first = scaled if first is None else first
        scaled = _flip(scaled, first)
        for method in methods:
            points = scaled if method == "mds" else _flip(_tsne(X, skeleton, metric, scaled, n_jobs), first)
            found.append(
                {
                    "metric": metric.label,
                    "method": method,
                    "unit": None if method == "tsne" else metric.unit,  # lengths of t-SNE mean nothing
                    "points": pack(points),
                    "share": float(scaling.explained_variance_ratio_.sum()) if method == "mds" else None,
                }
            )
    return found


def _flip(points: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Points, mirrored along the axes that point opposite to another plane."""
    return points * np.where((points * like).sum(axis=0) < 0.0, -1.0, 1.0)


def _tsne(X: np.ndarray, skeleton: Skeleton, metric: Metric, start: np.ndarray, n_jobs: int | None) -> np.ndarray:
    perplexity = min(PERPLEXITY, (len(X) - 1) / 3)
    k = min(len(X) - 1, int(3.0 * perplexity + 1.0))
    graph = PoseKNeighborsTransformer(skeleton, n_neighbors=k, metric=metric, n_jobs=n_jobs).fit_transform(X)
    small = 1e-4 * start / (start[:, 0].std() or 1.0)
    tsne = TSNE(
        metric="precomputed", perplexity=perplexity, init=small.astype(np.float32), random_state=0, n_jobs=n_jobs
    )
    return tsne.fit_transform(graph)


def skeleton_data(skeleton: Skeleton) -> dict[str, Any]:
    """A skeleton as an object of JSON, for `new Skeleton(data)` of assets/kinematics.js.

    Parameters
    ----------
    skeleton : Skeleton
        The skeleton.

    Returns
    -------
    dict
        Of each joint: `names`, `parents` (−1 for the root), `offsets` (m), `dofs`, `axes` (of hinges), `rests`,
        `weights` and `sides` ("left", "right" or ""). A rest rotation is a unit quaternion (w, x, y, z), or
        None for the identity. The names of the columns of a pose are `columns`. `offsetFrame` is "own" or "parent",
        and `shape` has the parts of the figure.

    Examples
    --------
    >>> from skpose import Bone, Skeleton
    >>> from skpose.view._explorer import skeleton_data
    >>> arm = Skeleton([Bone("left_arm", None, (0.3, 0, 0), "rotvec"), Bone("left_hand", "left_arm", (0.2, 0, 0), "z")])
    >>> data = skeleton_data(arm)
    >>> data["parents"], data["dofs"]
    ([-1, 0], ['rotvec', 'z'])
    """
    if slides := [bone.name for bone in skeleton.bones if bone.is_slide]:
        raise ValueError(f"skeleton must not slide, got {slides[0]!r}; player shows motions with slides")
    return {
        "names": list(skeleton.joint_names),
        "parents": skeleton.parents.tolist(),
        "offsets": skeleton.offsets.tolist(),
        "dofs": [bone.dofs for bone in skeleton.bones],
        "axes": [bone.axis for bone in skeleton.bones],
        "rests": [
            None if rest is None else Rotation.from_matrix(rest).as_quat()[[3, 0, 1, 2]].tolist()
            for rest in (bone.rest_rotation for bone in skeleton.bones)
        ],
        "weights": skeleton.weights.tolist(),
        "sides": sides(skeleton.joint_names),
        "shape": find_shape(skeleton).data(),
        "columns": list(skeleton.dof_names),
        "offsetFrame": skeleton.offset_frame,
    }
