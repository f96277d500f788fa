"""Writing the results of a command."""

from pathlib import Path

from skpose.io import save_bvh, save_csv, save_npz
from skpose.keypoints import Keypoints
from skpose.skeleton import Motion
from skpose.view import Page


def save_motion(content: Motion | Keypoints, out: Path, scale: float) -> None:
    """Write a motion or keypoints in the format of the suffix; `scale` is metres per unit of a BVH file."""
    if out.suffix.lower() == ".bvh":
        if isinstance(content, Keypoints):
            raise ValueError("keypoints have no skeleton, as BVH files need: choose .npz or .csv")
        save_bvh(out, content, scale=scale)
        if content.fitted:
            print("BVH files do not state that poses were fitted to positions; .npz files do")
        if scale != 1.0:
            print(f"BVH files do not state their unit: read this one with --scale {scale:g}")
    else:
        (save_npz if out.suffix.lower() == ".npz" else save_csv)(out, content)
    print(f"{out}: {content!r}")


def save_page(page: Page, out: Path | None, show: bool) -> None:
    """Write a page, and show it in the browser, from a temporary file if there is no `out`."""
    if out is not None:
        page.save(out)
        print(f"{out}: {page.note}, {page.n_bytes / 1e6:.2g} MB")
    if show:
        print(f"{page.open()}: open this file if no browser shows it")
