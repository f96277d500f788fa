"""The commands of the command line that compare, and that show."""

import shutil
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

import joblib
import numpy as np
from sklearn.neighbors import NearestNeighbors

from skpose._cli.colours import print_written
from skpose._cli.compare import COLUMNS, FRAME_RATE, PAPER, choose_actions, compare, prepare
from skpose._cli.inputs import check_one_frame_rate, files_in_messages, join_poses, read_labelled
from skpose._cli.labels import Labels
from skpose._cli.matrices import Names, name_motions, name_poses, read_matrix, write_graph, write_matrix
from skpose._cli.targets import REPORT, continues, is_unfinished
from skpose._files import check_new, created_meanwhile_error, new_file
from skpose._parallel.checkpoint import FileCheckpoint
from skpose.datasets import MotionDataset, make_actions, make_gait, walks_and_runs
from skpose.keypoints import Keypoints, layouts
from skpose.metrics import pose_distances
from skpose.metrics._shared import resolve
from skpose.motions import align_motions, motion_distances
from skpose.neighbors import PoseKNeighborsTransformer, PoseRadiusNeighborsTransformer
from skpose.skeleton import Motion
from skpose.skeleton._shared import check_comparable
from skpose.view import explorer, player

CHARACTERS = 20  # of a number in a CSV file, about
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


def distances(dataset: MotionDataset, metric: str, out: Path, dtype: str) -> None:
    """Write the matrix of distances between all poses to a file, or finish an interrupted one."""
    X, skeleton = join_poses(dataset).astype(dtype), dataset.motions[0].skeleton
    remedy = "use a lower --frame-rate, or --dtype float32"

    def compute(new: np.ndarray) -> None:
        pose_distances(X, skeleton=skeleton, metric=metric, out=new)

    if continues("distances", out):
        _write_matrix(out, len(X), X.dtype, remedy, compute)
    else:
        chosen = resolve(metric, skeleton)
        _write_named(out, name_poses(dataset), X.dtype, (chosen.label, chosen.unit), remedy, compute)


def motions(
    dataset: MotionDataset, metric: str, alignment: str, window: float | None, *, out: Path, dtype: str
) -> None:
    """Write the matrix of distances between whole motions to a file, or finish an interrupted one. Print the rows."""
    for row, (name, motion) in enumerate(zip(dataset.subjects, dataset, strict=True)):
        print(f"{row:>8} {len(motion):>8} frames  {name}")
    arrays, skeleton = [motion.angles.astype(dtype) for motion in dataset], dataset.motions[0].skeleton

    def compute(new: np.ndarray) -> None:
        motion_distances(arrays, skeleton=skeleton, metric=metric, alignment=alignment, window=window, out=new)

    remedy = "use --dtype float32"
    with files_in_messages(list(dataset.subjects), "X"):
        if continues("motions", out):
            _write_matrix(out, len(arrays), np.dtype(dtype), remedy, compute)
        else:
            chosen = resolve(metric, skeleton)
            measure = f"{chosen.label}, {alignment}" + ("" if window is None else f" within {window:g}")
            _write_named(out, name_motions(dataset), np.dtype(dtype), (measure, chosen.unit), remedy, compute)


def _write_named(
    out: Path,
    names: Names,
    dtype: np.dtype,
    measure: tuple[str, str],
    remedy: str,
    compute: Callable[[np.ndarray], object],
) -> None:
    """Compute a matrix in memory, and write it with the names of its rows, the metric and its unit."""
    n = len(names.rows)
    check_new(out)
    _check_room(out, n * n * (dtype.itemsize if out.suffix.lower() == ".npz" else CHARACTERS), remedy)
    D = np.zeros((n, n), dtype=dtype)
    compute(D)
    with new_file(out) as new:
        write_matrix(new, D, names, *measure)
    print_written(out, f"{n:,} × {n:,} distances with names, {dtype}")


def _write_matrix(out: Path, n: int, dtype: np.dtype, remedy: str, compute: Callable[[np.ndarray], object]) -> None:
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
        _check_room(out, n * n * dtype.itemsize, remedy)
        array = _new_matrix(out, shape, dtype)
    try:
        compute(array)
    except BaseException:
        if not notes.path.exists() and not array[:1].any():  # stopped before anything was computed
            out.unlink()
        raise
    print_written(out, f"{n:,} × {n:,} distances, {array.dtype}")


def _check_room(out: Path, size: int, remedy: str) -> None:
    """Refuse a file of so many bytes where the disk has no room for it."""
    free = shutil.disk_usage(out.absolute().parent).free
    if size > free:
        raise ValueError(f"{out} needs {size / 1e9:.1f} GB and the disk has {free / 1e9:.1f} GB free: {remedy}")


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


def neighbors(dataset: MotionDataset, metric: str, out: Path, n_neighbors: int, radius: float | None) -> None:
    """Write the graph of neighbours to a file. No pose is a neighbour of itself."""
    X, skeleton = join_poses(dataset), dataset.motions[0].skeleton
    if radius is None:
        search = PoseKNeighborsTransformer(skeleton, metric=metric, n_neighbors=n_neighbors).fit(X)
        graph = search.kneighbors_graph(mode="distance")
    else:
        search = PoseRadiusNeighborsTransformer(skeleton, metric=metric, radius=radius).fit(X)
        graph = search.radius_neighbors_graph(mode="distance")
    with new_file(out) as new:
        write_graph(new, graph, name_poses(dataset).rows)
    print_written(out, f"{graph.nnz:,} neighbours of {len(X):,} poses")


def neighbors_in(path: Path, out: Path, n_neighbors: int, radius: float | None) -> None:
    """Write the graph of the nearest rows of a file of distances. No row is a neighbour of itself."""
    matrix = read_matrix(path)
    of = "distances" + (f" by {matrix.metric}, {matrix.unit}" if matrix.metric else "")
    print(f"{path}: {len(matrix.distances):,} × {len(matrix.distances):,} {of}")
    if radius is None:
        search = NearestNeighbors(n_neighbors=n_neighbors, metric="precomputed").fit(matrix.distances)
        graph = search.kneighbors_graph(mode="distance")
    else:
        search = NearestNeighbors(radius=radius, metric="precomputed").fit(matrix.distances)
        graph = search.radius_neighbors_graph(mode="distance", sort_results=True)
    with new_file(out) as new:
        write_graph(new, graph, matrix.names)
    print_written(out, f"{graph.nnz:,} neighbours of {graph.shape[0]:,} rows")


def view(
    shown: list[Motion | Keypoints], names: list[str], out: Path, *, align: bool, overlay: bool, layout: str | None
) -> None:
    """Write a page that plays motions and keypoints."""
    if align and len(shown) != 2:
        raise ValueError(f"--align is for two files, got {len(shown)}: choose two, or leave --align out")
    alignment = None
    if align:
        motions = [one for one in shown if isinstance(one, Motion)]
        for name, one in zip(names, shown, strict=True):
            if not isinstance(one, Motion):
                raise ValueError(f"{name} has points without a skeleton, which --align needs. {WITHOUT_ALIGN}")
        check_comparable([motion.skeleton for motion in motions], names, WITHOUT_ALIGN, WITHOUT_ALIGN)
        check_one_frame_rate(MotionDataset(motions, names, names, names))
        alignment = align_motions(*motions)
    _check_layout_is_for(shown, layout)
    page = player(shown, labels=_shorten(names), alignment=alignment, layout=layout, overlay=overlay)
    page.save(out)
    print_written(out, f"{page.note}, {page.n_bytes / 1e6:.2g} MB")


def _check_layout_is_for(shown: list[Motion | Keypoints], layout: str | None) -> None:
    if layout is not None and all(isinstance(one, Motion) for one in shown):
        raise ValueError("--layout is for files of keypoints or markers, and these have skeletons: leave it out")


def draw(
    shown: list[Motion | Keypoints],
    names: list[str],
    png: Path | None,
    at: float | None,
    gif: Path | None,
    part: tuple[float | None, float | None],
    fps: float | None,
    layout: str | None,
) -> None:
    """Write a picture of motions and keypoints, a moving one, or both."""
    from skpose._cli.moving_picture import FPS, Recording  # slow to import

    _check_layout_is_for(shown, layout)
    recording = Recording(shown, _shorten(names), None if layout is None else layouts[layout])
    if png is not None:
        recording.save_png(png, at)
        print_written(png, f"{png.stat().st_size / 1e6:.2g} MB")
    if gif is not None:
        n = recording.save_gif(gif, *part, FPS if fps is None else fps)
        print_written(gif, f"{n} picture{'s' * (n != 1)}, {gif.stat().st_size / 1e6:.2g} MB")


def check_matplotlib(what: str) -> None:
    """Refuse what cannot be drawn before anything is read."""
    if find_spec("matplotlib") is None:
        raise ValueError(f"{what} matplotlib: pip install 'skpose[plot]'")


def explore(
    dataset: MotionDataset, labels: Labels, metrics: Sequence[str], embeddings: Sequence[str], out: Path, n_jobs: int
) -> None:
    """Write a page of all poses; the motions of the dataset have the names of their files."""
    names = list(dataset.subjects)
    known = {name: getattr(labels, name) for name in ("subjects", "trials", "actions") if any(getattr(labels, name))}
    every = all(map(any, zip(labels.subjects, labels.actions, strict=True)))
    page = explorer(
        MotionDataset(dataset.motions, **known),
        metrics=metrics,
        embeddings=embeddings,
        frame_rate=None,  # that of the dataset
        labels=None if every else _shorten(names),
        n_jobs=n_jobs,
    )
    page.save(out)
    print_written(out, f"{page.note}, {page.n_bytes / 1e6:.2g} MB")


def _shorten(names: Sequence[str]) -> list[str]:
    """Return the names of files without their folders, unless two are equal then."""
    short = [Path(name).name for name in names]
    return short if len(set(short)) == len(short) else list(names)


def reproduce(folder: Path | None, scale: float | Literal["auto"] | None, out: Path, seed: int, n_jobs: int) -> None:
    """Repeat section 3 of the paper: print the numbers, and write them with the figures to a folder."""
    check_matplotlib("the figures need")
    from skpose._cli import report  # slow to import
    from skpose._cli import reproduce as studies

    if folder is None:
        dataset, source = make_gait(random_state=seed), f"generated gait, make_gait(random_state={seed})"
    else:
        dataset = read_labelled(folder, scale)
        source = f"{len(dataset)} motions of {len(set(dataset.subjects))} people in the folder {folder.resolve().name}"
    findings = studies.reproduce(dataset, seed, n_jobs=n_jobs)
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


def compare_metrics(
    folder: Path | None, scale: float | Literal["auto"] | None, out: Path | None, n_jobs: int, *, paper: bool
) -> None:
    """Print how well actions are recognised under each metric; draw it to a file."""
    if out is not None:
        check_new(out)
        check_matplotlib("the picture needs")
    if folder is not None:
        dataset, source = read_labelled(folder, scale, walks_and_runs if paper else choose_actions), str(folder)
    elif paper:
        dataset, source = make_gait(random_state=0), "generated gait, skpose.datasets.make_gait(random_state=0)"
    else:
        dataset, source = make_actions(random_state=0), "generated, skpose.datasets.make_actions(random_state=0)"
    n_all, dataset = len(dataset), prepare(dataset, paper=paper)
    actions, people = set(dataset.actions), set(dataset.subjects)
    print(f"{'Walking or running' if paper else 'Which action is it'}? {source}")
    joints = "angles as they are" if paper else "ball joints"
    print(
        f"{len(dataset)} motions of {len(actions)} actions by {len(people)} people, {sum(map(len, dataset)):,} poses "
        f"at {FRAME_RATE:g} Hz, {joints}"
    )
    if len(dataset) < n_all:
        kept = "walks and runs" if paper else "actions that two people do" if len(people) > 1 else "actions done twice"
        print(f"{n_all - len(dataset)} motions are left out: only {kept} are compared")
    print(f"\n{'':<10}{'nearest neighbour right':^40}{'variance in':>13}")
    print(f"{'':<10}{'among other people':>20}{'among other motions':>20}{'first MDS':>13}")
    print(f"{'metric':<10}{'frames':>11}{'motions':>9}{'frames':>11}{'motions':>9}{'component':>13}{'time':>10}")
    rows = []
    for row in compare(dataset, n_jobs=n_jobs):
        rows.append(row)
        shares = ["-" if np.isnan(value) else f"{value:.1%}" for value in row[1:-1]]
        widths = (11, 9, 11, 9, 13)
        cells = "".join(f"{cell:>{width}}" for cell, width in zip(shares, widths, strict=True))
        print(f"{row.metric:<10}{cells}{row.seconds:>8.2f} s", flush=True)
    if len(people) < 2:
        print("\n-: all motions are of one person, so that there are no others.")
    print("\n" + "\n".join(textwrap.wrap(COLUMNS, 100)))
    if paper:
        print("\n".join(textwrap.wrap(PAPER, 100)))
    if out is not None:
        from skpose._cli.picture import draw  # slow to import

        with new_file(out) as new:
            draw(dataset, rows, new)
        print(f"\n{out}: the table as a picture, with a pose of each action")
