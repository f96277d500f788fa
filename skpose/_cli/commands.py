"""The commands of the command line."""

import re
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

import joblib
import numpy as np
from scipy.sparse import save_npz

from skpose._cli.compare import COLUMNS, FRAME_RATE, PAPER_ACCURACY, PAPER_FIRST_COMPONENT, compare
from skpose._parallel.checkpoint import FileCheckpoint
from skpose.datasets import MotionDataset, load_cmu, make_gait, walks_and_runs
from skpose.io import file_format, load_asf, load_motion
from skpose.metrics import pose_distances
from skpose.neighbors import PoseKNeighborsTransformer, PoseRadiusNeighborsTransformer
from skpose.skeleton import Skeleton


def read_poses(
    files: Sequence[Path],
    rate: float | None,
    reading: dict[str, Any],
    *,
    rotations: Literal["rotvec"] | None = None,
    rest: Literal["raise", "world", "same"] = "raise",
    with_root: Literal["tilt", "whole"] | None = None,
    up: Literal["x", "y", "z"] | None = None,
) -> tuple[np.ndarray, Skeleton]:
    """Read all files; return their poses on the mean skeleton. Print which rows belong to which file.

    Poses with another `rest` than "raise" are on the skeleton of the first file.
    """
    motions = [load_motion(path, **reading) for path in files]
    names = [str(path) for path in files]
    dataset = MotionDataset(motions, names, names, names)
    try:
        if rotations == "rotvec":
            dataset = dataset.to_rotvec()
        if rest != "raise":
            dataset = dataset.retarget(dataset.motions[0].skeleton, rest=rest)
        if with_root is not None:
            dataset = dataset.with_root(with_root, up=up)
        X, sequence = dataset.poses(rate)
    except ValueError as error:  # which names motions by their index
        message = re.sub(r"(?<![\w.])motions\[(\d+)\]", lambda found: names[int(found[1])], str(error))
        raise ValueError(message) from None
    ends = np.searchsorted(sequence, np.arange(len(files)), side="right")
    for path, first, end in zip(files, [0, *ends], ends, strict=False):
        print(f"{first:>8} to {end - 1:<8} {path}")
    return X, dataset.skeleton


@contextmanager
def backend(name: str, scheduler: str | None, n_jobs: int) -> Iterator[None]:
    """Configure joblib's backend."""
    if name == "dask":
        try:
            from dask.distributed import Client
        except ImportError:
            raise ValueError("--backend dask needs dask: pip install 'skpose[dask]'") from None
        n_workers = joblib.effective_n_jobs(n_jobs)
        cluster = {"n_workers": n_workers, "threads_per_worker": 1} if scheduler is None else {"address": scheduler}
        with Client(**cluster), joblib.parallel_config("dask"):
            yield
    elif name == "ray":
        try:
            import ray
            from ray.util.joblib import register_ray
        except ImportError:
            raise ValueError("--backend ray needs ray: pip install 'skpose[ray]'") from None
        ray.init(address=scheduler)
        register_ray()
        with joblib.parallel_config("ray", n_jobs=n_jobs):
            yield
    else:
        with joblib.parallel_config("threading" if name == "threads" else name, n_jobs=n_jobs):
            yield


def distances(X: np.ndarray, skeleton: Skeleton, metric: str, out: Path, dtype: str) -> None:
    """Write the matrix of distances to a file, or finish an interrupted one."""
    X, shape = X.astype(dtype), (len(X), len(X))
    notes = FileCheckpoint(out)
    if out.exists() and notes.path.exists():
        array = np.lib.format.open_memmap(out, mode="r+")
        print(f"{out} is unfinished: continuing")
    else:
        _refuse_to_overwrite(out)
        if notes.read() is not None:  # on a matrix that has been deleted
            notes.remove()
        size, free = shape[0] * shape[1] * X.dtype.itemsize, shutil.disk_usage(out.absolute().parent).free
        if size > free:
            raise ValueError(
                f"{out} needs {size / 1e9:.1f} GB and the disk has {free / 1e9:.1f} GB free: use a lower --rate, or "
                "--dtype float32"
            )
        array = np.lib.format.open_memmap(out, mode="w+", dtype=X.dtype, shape=shape)
    pose_distances(X, skeleton=skeleton, metric=metric, out=array, verbose=1)
    print(f"{out}: {shape[0]:,} × {shape[1]:,} distances, {array.dtype}")


def neighbors(
    X: np.ndarray, skeleton: Skeleton, metric: str, out: Path, n_neighbors: int, radius: float | None
) -> None:
    """Write the graph of neighbours to a file. No pose is a neighbour of itself."""
    _refuse_to_overwrite(out)
    if radius is None:
        search = PoseKNeighborsTransformer(skeleton, metric=metric, n_neighbors=n_neighbors, verbose=1).fit(X)
        graph = search.kneighbors_graph(mode="distance")
    else:
        search = PoseRadiusNeighborsTransformer(skeleton, metric=metric, radius=radius, verbose=1).fit(X)
        graph = search.radius_neighbors_graph(mode="distance")
    new = out.with_name(f"{out.name}.new")
    with new.open("wb") as file:  # given a name, save_npz would append ".npz" to it
        save_npz(file, graph)
    new.replace(out)
    print(f"{out}: {graph.nnz:,} neighbours of {len(X):,} poses")


def _refuse_to_overwrite(out: Path) -> None:
    if out.exists():
        raise FileExistsError(f"{out} already exists: delete it or choose another file")


def info(files: Sequence[Path], reading: dict[str, Any]) -> None:
    """Print the contents of each file: frames, joints, degrees of freedom; its name, if there are several."""
    for i, path in enumerate(files):
        if len(files) > 1:
            print(f"{chr(10) * (i > 0)}{path}")
        _describe(path, reading)


def _describe(path: Path, reading: dict[str, Any]) -> None:
    if file_format(path) == "ASF":
        skeleton = load_asf(path, scale=reading["scale"])
    else:
        motion = load_motion(path, **reading)
        skeleton = motion.skeleton
        print(f"{len(motion)} frames at {motion.frame_rate:g} Hz, {len(motion) / motion.frame_rate:.2f} s")
    print(f"{skeleton.n_joints} joints besides the root, {skeleton.n_dofs} degrees of freedom\n")
    width = max(len(name) for name in ("joint", "parent", *skeleton.joint_names))
    print(f"{'joint':<{width}}  {'parent':<{width}}  {'bone, m':>8}  rotates about")
    for bone in skeleton.bones:
        length = np.linalg.norm(bone.offset)
        print(f"{bone.name:<{width}}  {bone.parent or 'root':<{width}}  {length:>8.3f}  {bone.dofs or '-'}")


def reproduce(folder: Path | None, out: Path, seed: int, n_jobs: int) -> None:
    """Repeat section 3 of the paper: print the numbers, and write them with the figures to a folder."""
    if find_spec("matplotlib") is None:
        raise ValueError("the figures need matplotlib: pip install 'skpose[plot]'")
    from skpose._cli import report  # slow to import
    from skpose._cli import reproduce as studies

    if folder is None:
        dataset, source = make_gait(random_state=seed), f"generated gait, make_gait(random_state={seed})"
    else:
        dataset = load_cmu(folder)
        source = f"{len(dataset)} motions of {len(set(dataset.subjects))} people of the CMU database"
    findings = studies.reproduce(dataset, seed, n_jobs=n_jobs, verbose=1)
    print(report.text(findings))
    out.mkdir(parents=True, exist_ok=True)
    command = f"skpose reproduce {'' if folder is None else 'FOLDER '}--out DIR --seed {seed}"
    (out / "README.md").write_text(report.markdown(findings, source, command), encoding="utf-8")
    (out / "table.txt").write_text(report.text(findings) + "\n", encoding="utf-8")
    report.draw(findings, out)
    print(f"\nWritten to {out}: README.md, table.txt, figure_3.png, figure_4.png")


def compare_metrics(folder: Path | None, n_jobs: int) -> None:
    """Print how well each metric classifies walking and running."""
    if folder is None:
        dataset, source = make_gait(random_state=0), "generated gait, skpose.datasets.make_gait(random_state=0)"
    else:
        dataset, source = load_cmu(folder), str(folder)
    dataset = walks_and_runs(dataset)
    n_poses = len(dataset.poses(FRAME_RATE)[0])
    print(f"Walking or running? {source}")
    counts = ", ".join(f"{(dataset.actions == name).sum()} {name}s" for name in ("walk", "run"))
    print(f"{counts}, {len(set(dataset.subjects))} subjects, {n_poses} poses at {FRAME_RATE:g} Hz")
    print(f"\n{'':<10}{'nearest neighbour right':^36}{'variance in first':^22}")
    print(f"{'':<10}{'leave one':>11}{'leave one':>11}{'paper,':>12}{'MDS component,':>17}")
    print(f"{'metric':<10}{'subject out':>12}{'seq. out':>10}{'seq. out':>12}{'median':>11}{'paper':>8}{'time':>10}")
    for row in compare(dataset, n_jobs=n_jobs):
        paper, component = (
            f"{values[row.metric]:.0%}" if row.metric in values else "-"
            for values in (PAPER_ACCURACY, PAPER_FIRST_COMPONENT)
        )
        print(
            f"{row.metric:<10}{row.leave_subject_out:>12.1%}{row.leave_sequence_out:>10.1%}{paper:>12}"
            f"{row.first_component:>11.1%}{component:>8}{row.seconds:>8.2f} s",
            flush=True,
        )
    print(COLUMNS)
    print("\nPaper: Hauberg & Pedersen 2012, other sequences of the CMU data. Sec. 3.3: ten walks and ten runs, 1,096")
    print("poses; fig. 4 (c): modes over 673 sequences. Time: distances, validation and scaling, not compilation.")
