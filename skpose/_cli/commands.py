"""The commands of the command line."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import joblib
import numpy as np
from scipy.sparse import save_npz

from skpose._cli.compare import COLUMNS, FRAME_RATE, PAPER_ACCURACY, PAPER_FIRST_COMPONENT, compare
from skpose._cli.inputs import (
    check_one_frame_rate,
    files_in_messages,
    motion_files,
    read_gait,
)
from skpose._cli.labels import Labels
from skpose._cli.reader import Rate, Reader, name_of
from skpose._cli.stored import describe_stored
from skpose._cli.targets import REPORT, is_unfinished
from skpose._files import check_new, created_meanwhile_error, new_file
from skpose._parallel.checkpoint import FileCheckpoint
from skpose.datasets import MotionDataset, make_gait, walks_and_runs
from skpose.io import file_format, load_asf, load_c3d, load_motion, load_trc
from skpose.io._shared import Stored, has_keypoints, read_stored
from skpose.keypoints import Keypoints
from skpose.metrics import pose_distances
from skpose.metrics._shared import resolve
from skpose.motions import align_motions, find_motion, motion_distances
from skpose.neighbors import PoseKNeighborsTransformer, PoseRadiusNeighborsTransformer
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import check_comparable
from skpose.view import explorer, player

WITHOUT_ALIGN = "Leave --align out to see them side by side"


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
    X = X.astype(dtype)
    remedy = "use a lower --frame-rate, or --dtype float32"
    _write_matrix(
        out,
        len(X),
        X.dtype,
        remedy,
        lambda new: pose_distances(X, skeleton=skeleton, metric=metric, out=new, verbose=1),
    )


def motions(
    dataset: MotionDataset, metric: str, alignment: str, window: float | None, *, out: Path, dtype: str
) -> None:
    """Write the matrix of distances between whole motions to a file, or finish an interrupted one. Print the rows."""
    for row, (name, motion) in enumerate(zip(dataset.subjects, dataset, strict=True)):
        print(f"{row:>8} {len(motion):>8} frames  {name}")
    arrays, skeleton = [motion.angles.astype(dtype) for motion in dataset], dataset.motions[0].skeleton

    def compute(new: np.memmap) -> None:
        motion_distances(
            arrays, skeleton=skeleton, metric=metric, alignment=alignment, window=window, out=new, verbose=1
        )

    with files_in_messages(list(dataset.subjects), "X"):
        _write_matrix(out, len(arrays), np.dtype(dtype), "use --dtype float32", compute)


def _write_matrix(out: Path, n: int, dtype: np.dtype, remedy: str, compute: Callable[[np.memmap], object]) -> None:
    """Compute an n × n matrix in a new file, or finish an interrupted one; the remedy is for a disk that is full."""
    shape, notes = (n, n), FileCheckpoint(out)
    if is_unfinished(out):
        array = np.lib.format.open_memmap(out, mode="r+")
        if (array.shape, array.dtype) != (shape, dtype):
            raise ValueError(
                f"{out} is an unfinished matrix of {array.shape[0]:,} × {array.shape[-1]:,} {array.dtype}, expected "
                f"{n:,} × {n:,} {dtype}: finish it with the command that started it, or delete it"
            )
        print(f"{out} is unfinished: continuing")
    else:
        check_new(out)
        if notes.read() is not None:  # on a matrix that has been deleted
            notes.remove()
        size, free = n * n * dtype.itemsize, shutil.disk_usage(out.absolute().parent).free
        if size > free:
            raise ValueError(f"{out} needs {size / 1e9:.1f} GB and the disk has {free / 1e9:.1f} GB free: {remedy}")
        array = _new_matrix(out, shape, dtype)
    try:
        compute(array)
    except BaseException:
        if not notes.path.exists() and not array[:1].any():  # stopped before anything was computed
            out.unlink()
        raise
    print(f"{out}: {n:,} × {n:,} distances, {array.dtype}")


def _new_matrix(out: Path, shape: tuple[int, int], dtype: np.dtype) -> np.memmap:
    """Return a new matrix on disk, or leave no file if there is no room for it."""
    try:
        out.touch(exist_ok=False)  # numpy would empty a file that was created since the check
    except FileExistsError:
        raise created_meanwhile_error(out) from None
    try:
        return np.lib.format.open_memmap(out, mode="w+", dtype=dtype, shape=shape)
    except BaseException:
        out.unlink()
        raise


def neighbors(
    X: np.ndarray, skeleton: Skeleton, metric: str, out: Path, n_neighbors: int, radius: float | None
) -> None:
    """Write the graph of neighbours to a file. No pose is a neighbour of itself."""
    if radius is None:
        search = PoseKNeighborsTransformer(skeleton, metric=metric, n_neighbors=n_neighbors, verbose=1).fit(X)
        graph = search.kneighbors_graph(mode="distance")
    else:
        search = PoseRadiusNeighborsTransformer(skeleton, metric=metric, radius=radius, verbose=1).fit(X)
        graph = search.radius_neighbors_graph(mode="distance")
    with new_file(out) as new, new.open("wb") as file:  # to a path save_npz adds .npz, also where it ends in .NPZ
        save_npz(file, graph)
    print(f"{out}: {graph.nnz:,} neighbours of {len(X):,} poses")


def find(dataset: MotionDataset, begins: float | None, ends: float | None, k: int, metric: str, n_jobs: int) -> None:
    """Print where a motion is found in others. It is the first of the dataset, or its part between two times in s."""
    query, *recordings = dataset.motions
    name, *names = dataset.subjects
    query = _cut(query, begins, ends, name)
    with files_in_messages(names):
        found = find_motion(query, recordings, k=k, skeleton=query.skeleton, metric=metric, n_jobs=n_jobs, verbose=1)
    width = max(len(name) for name in ("file", *names))
    distance = f"distance, {resolve(metric, query.skeleton).unit}"
    print(f"{'rank':>6}  {'file':<{width}}  {'start, s':>10}  {'end, s':>10}  {distance:>14}")
    for rank, (i, start, stop, far) in enumerate(found, start=1):
        times = f"{recordings[i].times[start]:>10.2f}  {_end(recordings[i], stop - 1):>10.2f}"
        print(f"{rank:>6}  {names[i]:<{width}}  {times}  {far:>14.4f}")


def _cut(motion: Motion, begins: float | None, ends: float | None, name: str) -> Motion:
    """Return the frames between two times, s."""
    first, last = np.searchsorted(motion.times, [begins or 0.0, np.inf if ends is None else ends])
    if first == last:
        until = "" if ends is None else f" and before {ends:g} s"
        raise ValueError(
            f"{name} has no frame from {begins or 0:g} s on{until}, as it lasts {_end(motion, -1):.2f} s: choose other "
            "times for --from and --to"
        )
    return motion[first:last]


def _end(motion: Motion, row: int) -> float:
    """Return the time at which a frame ends, s."""
    return motion.times[row] + 1.0 / motion.frame_rate


def view(motions: list[Motion], names: list[str], out: Path, *, align: bool, overlay: bool) -> None:
    """Write a page that plays the motions."""
    if align and len(motions) != 2:
        raise ValueError(f"--align is for two files, got {len(motions)}: choose two, or leave --align out")
    alignment = None
    if align:
        check_comparable([motion.skeleton for motion in motions], names, WITHOUT_ALIGN, WITHOUT_ALIGN)
        check_one_frame_rate(MotionDataset(motions, names, names, names))
        alignment = align_motions(*motions)
    page = player(motions, labels=_shorten(names), alignment=alignment, overlay=overlay)
    page.save(out)
    print(f"{out}: {page.note}, {page.n_bytes / 1e6:.2g} MB")


def explore(dataset: MotionDataset, labels: Labels, metrics: Sequence[str], out: Path, n_jobs: int) -> None:
    """Write a page of all poses; the motions of the dataset have the names of their files."""
    names = list(dataset.subjects)
    known = {name: getattr(labels, name) for name in ("subjects", "trials", "actions") if any(getattr(labels, name))}
    every = all(map(any, zip(labels.subjects, labels.actions, strict=True)))
    page = explorer(
        MotionDataset(dataset.motions, **known),
        metrics=metrics,
        frame_rate=None,  # that of the dataset
        labels=None if every else _shorten(names),
        n_jobs=n_jobs,
        verbose=1,
    )
    page.save(out)
    print(f"{out}: {page.note}, {page.n_bytes / 1e6:.2g} MB")


def _shorten(names: Sequence[str]) -> list[str]:
    """Return the names of files without their folders, unless two are equal then."""
    short = [Path(name).name for name in names]
    return short if len(set(short)) == len(short) else list(names)


def info(files: Sequence[Path], reader: Reader) -> None:
    """Print the contents of each file: frames, joints or points, degrees of freedom; its name, if there are several."""
    files, blank = motion_files(files, (".bvh", ".amc", ".asf", ".trc", ".c3d")), ""
    for path, content in reader.read(files, _load):
        if len(files) > 1:
            print(f"{blank}{name_of(path)}")
            blank = "\n"
        if isinstance(content, Stored):
            describe_stored(content)
        elif isinstance(content, Keypoints):
            _describe_points(content)
        else:
            _describe(content, reader.rates.get(path))


def _load(file: Path | BytesIO, **options: Any) -> Motion | Skeleton | Keypoints | Stored:
    """Return the content of a file of any format."""
    is_stored = has_keypoints(file)
    if isinstance(file, BytesIO):
        file.seek(0)
    if is_stored:
        return read_stored(file)
    kind = file_format(file)
    if isinstance(file, BytesIO):
        file.seek(0)
    if kind == "ASF":
        return load_asf(file, scale=options["scale"])
    if kind in ("TRC", "C3D"):
        shared = {name: options[name] for name in ("scale", "up") if options[name] is not None}
        if kind == "C3D":
            return load_c3d(file, **shared)
        return load_trc(file, frame_rate=options["frame_rate"], trust=options["trust"], **shared)
    return load_motion(file, **options)


def _describe(content: Motion | Skeleton, rate: Rate | None) -> None:
    skeleton, root = (content, "root") if isinstance(content, Skeleton) else (content.skeleton, content.root_name)
    if isinstance(content, Motion):
        by = f" by {rate.origin}" if rate is not None and rate.hertz == content.frame_rate else ""
        seconds = len(content) / content.frame_rate
        print(f"{len(content)} frames at {content.frame_rate:g} Hz{by}, {seconds:.2f} s, {content.up} up")
    print(f"{skeleton.n_joints} joints besides the root, {skeleton.n_dofs} degrees of freedom\n")
    width = max(len(name) for name in ("joint", "parent", root, *skeleton.joint_names))
    print(f"{'joint':<{width}}  {'parent':<{width}}  {'bone, m':>8}  rotates about")
    for bone in skeleton.bones:
        length = np.linalg.norm(bone.offset)
        print(f"{bone.name:<{width}}  {bone.parent or root:<{width}}  {length:>8.3f}  {bone.dofs or '-'}")


def _describe_points(points: Keypoints) -> None:
    print(f"{len(points)} frames at {points.frame_rate:g} Hz, {len(points) / points.frame_rate:.2f} s")
    print(f"{len(points.names)} points, {points.up} is up\n")
    width = max(len(name) for name in ("point", *points.names))
    print(f"{'point':<{width}}  not seen")
    for name, confidences in zip(points.names, points.confidences.T, strict=True):
        print(f"{name:<{width}}  {np.mean(confidences == 0.0):>8.1%}")


def reproduce(folder: Path | None, scale: float | Literal["auto"] | None, out: Path, seed: int, n_jobs: int) -> None:
    """Repeat section 3 of the paper: print the numbers, and write them with the figures to a folder."""
    if find_spec("matplotlib") is None:
        raise ValueError("the figures need matplotlib: pip install 'skpose[plot]'")
    from skpose._cli import report  # slow to import
    from skpose._cli import reproduce as studies

    if folder is None:
        dataset, source = make_gait(random_state=seed), f"generated gait, make_gait(random_state={seed})"
    else:
        dataset = read_gait(folder, scale)
        source = f"{len(dataset)} motions of {len(set(dataset.subjects))} people in the folder {folder.resolve().name}"
    findings = studies.reproduce(dataset, seed, n_jobs=n_jobs, verbose=1)
    print(report.text(findings))
    given = ("" if folder is None else "FOLDER ") + (
        "" if scale is None else f"--scale {scale if scale == 'auto' else format(scale, 'g')} "
    )
    command = f"skpose reproduce {given}--out DIR --seed {seed}"
    out.mkdir(exist_ok=True)
    with ExitStack() as files:  # all of them or none
        document, table, *figures = (files.enter_context(new_file(out / name)) for name in REPORT)
        document.write_text(report.markdown(findings, source, command), encoding="utf-8")
        table.write_text(report.text(findings) + "\n", encoding="utf-8")
        report.draw(findings, *figures)
    print(f"\nWritten to {out}: {', '.join(REPORT)}")


def compare_metrics(folder: Path | None, scale: float | Literal["auto"] | None, n_jobs: int) -> None:
    """Print how well each metric classifies walking and running."""
    if folder is None:
        dataset, source = make_gait(random_state=0), "generated gait, skpose.datasets.make_gait(random_state=0)"
    else:
        dataset, source = read_gait(folder, scale), str(folder)
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
        ours = (row.leave_subject_out, row.leave_sequence_out, row.first_component)
        subject_out, sequence_out, first = ("-" if np.isnan(value) else f"{value:.1%}" for value in ours)
        print(
            f"{row.metric:<10}{subject_out:>12}{sequence_out:>10}{paper:>12}"
            f"{first:>11}{component:>8}{row.seconds:>8.2f} s",
            flush=True,
        )
    if len(set(dataset.subjects)) < 2:
        print("\n-: all motions are of one subject, so that none can be left out.")
    print(COLUMNS)
    print("\nPaper: Hauberg & Pedersen 2012, other sequences of the CMU data. Sec. 3.3: ten walks and ten runs, 1,096")
    print("poses; fig. 4 (c): modes over 673 sequences. Time: distances, validation and scaling, not compilation.")
