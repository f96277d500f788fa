"""Writing the results of a command."""

from pathlib import Path

from skpose.io import save_bvh, save_csv, save_npz, save_smpl
from skpose.keypoints import Keypoints
from skpose.skeleton import Motion
from skpose.view import Page


def save_motion(content: Motion | Keypoints, out: Path, scale: float, smpl: bool) -> None:
    """Write a motion or keypoints in the format of the suffix; `scale` is metres per unit of a BVH file."""
    suffix = out.suffix.lower()
    on_smpl = suffix == ".npy" or (smpl and suffix == ".npz")
    if suffix != ".bvh" and not on_smpl:
        (save_npz if suffix == ".npz" else save_csv)(out, content)
    elif isinstance(content, Keypoints):
        raise ValueError("keypoints have no skeleton, as BVH and SMPL files need: choose .npz or .csv")
    elif on_smpl:
        save_smpl(out, content, content="joints" if suffix == ".npy" else "poses")
    else:
        save_bvh(out, content, scale=scale)
        if content.fitted:
            print("BVH files do not state that poses were fitted to positions; .npz files do")
        if scale != 1.0:
            print(f"BVH files do not state their unit: read this one with --scale {scale:g}")
    print(f"{out}: {'22 joints at 20 Hz' if suffix == '.npy' else repr(content)}")


def save_page(page: Page, out: Path | None, show: bool) -> None:
    """Write a page, and show it in the browser, from a temporary file if there is no `out`."""
    if out is not None:
        page.save(out)
        print(f"{out}: {page.note}, {page.n_bytes / 1e6:.2g} MB")
    if show:
        print(f"{page.open()}: open this file if no browser shows it")
