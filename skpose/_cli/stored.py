"""Contents of a file of keypoints, whether or not it states all that `skpose.io.load_keypoints` needs."""

import numpy as np

from skpose.io._shared import Stored


def describe_stored(stored: Stored) -> None:
    """Print frames, frame rate, points, how often each is not seen, and which arguments `load_keypoints` needs."""
    n_frames, n_points, _ = stored.positions.shape
    needed = []
    if stored.frame_rate is None:
        print(f"{n_frames} frames, whose rate it does not state")
        needed.append("frame_rate=")
    else:
        print(f"{n_frames} frames at {stored.frame_rate:g} Hz, {n_frames / stored.frame_rate:.2f} s")
    if stored.names is None:
        print(f"{n_points} keypoints, which it does not name")
        needed.append("names= or layout=")
    else:
        print(f"{n_points} points" + ("" if stored.up is None else f", {stored.up} is up"))
    if needed:
        print(f"skpose.io.load_keypoints reads it with {' and '.join(needed)}")
    not_seen = np.isnan(stored.positions).any(axis=2)
    if stored.confidences is not None:
        not_seen |= stored.confidences == 0.0
    names = stored.names or [str(i) for i in range(n_points)]
    width = max(len(name) for name in ("point", *names))
    print(f"\n{'point':<{width}}  not seen")
    for name, share in zip(names, not_seen.mean(axis=0) if n_frames else np.zeros(n_points), strict=True):
        print(f"{name:<{width}}  {share:>8.1%}")
