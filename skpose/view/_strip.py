"""Poses of a motion side by side, as a picture (SVG) that is small and needs no program."""

import html
from dataclasses import replace

import numpy as np

from skpose.skeleton import Motion
from skpose.skeleton._shared import sides
from skpose.view._scene import Scene, scene_of

N_POSES = 8
HEIGHT, GAP, MARGIN = 150, 14, 8  # of a figure, between two, around all, px
# Colours that colour-blind people can distinguish, on white and on black; the middle line is in the colour of the text.
COLOURS = {"": "currentColor", "left": "#0072b2", "right": "#d55e00"}


def strip(motion: Motion) -> str:
    """Return poses of a motion at equal intervals, the first and the last among them, with their times.

    Each is seen from the side from which the motion is widest, and stands on the same ground.
    """
    description = html.escape(repr(motion))
    if not len(motion):
        return f"<p>{description}</p>"
    frames = np.unique(np.rint(np.linspace(0, len(motion) - 1, N_POSES)).astype(int))
    columns = ("angles", "root_positions", "root_angles", "frame_numbers")
    motion = replace(motion, **{name: getattr(motion, name)[frames] for name in columns}, seen=None)
    flat = _project(scene_of(motion))
    scale = HEIGHT / max(float(np.ptp(flat[..., 1])), 0.25 * float(np.ptp(flat[..., 0], axis=1).max()), 1e-9)
    flat = scale * (flat - [0.0, flat[..., 1].min()])
    left, right = flat[..., 0].min(axis=1), flat[..., 0].max(axis=1)
    step = max(float((right - left).max()) + GAP, 44.0)  # room for the time
    centres = MARGIN + step * (np.arange(len(frames)) + 0.5)
    width, height = int(np.ceil(2 * MARGIN + step * len(frames))), HEIGHT + 2 * MARGIN + 18
    figures = []
    for pose, centre, middle, time in zip(flat, centres, (left + right) / 2.0, motion.times, strict=True):
        points = np.rint(np.stack([pose[:, 0] - middle + centre, HEIGHT + MARGIN - pose[:, 1]], axis=1)).astype(int)
        figures += _lines(motion, points)
        figures.append(f'<text x="{centre:.0f}" y="{height - 6}" stroke="none">{time:.2f} s</text>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'role="img" style="max-width: 100%; height: auto" fill="none" stroke-width="2.5" stroke-linecap="round" '
        'stroke-linejoin="round"><title>'
        f'{description}</title><g fill="currentColor" font-size="12" font-family="sans-serif" text-anchor="middle">'
        f"{''.join(figures)}</g></svg>"
    )


def _project(scene: Scene) -> np.ndarray:
    """Return all points (n_frames, 1 + n_joints, 2), the root first, as seen from the side; where it goes is right."""
    joints = scene.joints + [[0.0, 1.0, 0.0]] * scene.root[:, None]
    points = np.concatenate([scene.root[:, None] * [0.0, 1.0, 0.0], joints], axis=1)
    horizontal = points[..., [0, 2]]
    _, _, rows = np.linalg.svd((horizontal - horizontal.mean(axis=(0, 1))).reshape(-1, 2), full_matrices=False)
    direction = rows[0]
    travelled = (scene.root[-1] - scene.root[0])[[0, 2]] @ direction
    sign = travelled if abs(travelled) > 1e-9 * scene.size else direction[np.abs(direction).argmax()]
    return np.stack([horizontal @ direction * np.sign(sign), points[..., 1]], axis=-1)


def _lines(motion: Motion, points: np.ndarray) -> list[str]:
    """Return the bones of one pose as a path for each side; the middle line is behind."""
    side = sides(motion.skeleton.joint_names)
    found = []
    for name, colour in COLOURS.items():
        bones = [
            f"M{x} {y}L{u} {v}"
            for j, (x, y) in enumerate(points[1:])
            if side[j] == name
            for u, v in [points[motion.skeleton.parents[j] + 1]]
        ]
        if bones:
            found.append(f'<path stroke="{colour}" fill="none" d="{"".join(bones)}"/>')
    return found
