"""Poses of a motion side by side, as a small picture (SVG) that needs no program."""

import html
from dataclasses import replace

import numpy as np

from skpose.skeleton import Motion
from skpose.skeleton._sides import sides
from skpose.view._scene import Scene, scene_of
from skpose.view._shape import Shape, find_shape, outline

N_POSES = 8
HEIGHT, GAP, MARGIN = 150, 14, 8  # of a figure, between two, around all, px
# Colours that colour-blind people can distinguish, on white and on black.
COLOURS = {"": "#868d96", "left": "#0072b2", "right": "#d55e00"}
N_CORNERS = 16  # of an outline
FINE = 2  # steps of a px to which outlines are rounded
STILL = 1e-3  # sizes; smaller movements count as standing still


def strip(motion: Motion) -> str:
    """Poses of a motion at equal intervals, the first and the last among them, with their times.

    They are seen from the side that shows the movement, or from the widest side if nothing moves, on one ground.
    """
    description = html.escape(repr(motion))
    if not len(motion):
        return f"<p>{description}</p>"
    frames = np.unique(np.rint(np.linspace(0, len(motion) - 1, N_POSES)).astype(int))
    columns = ("angles", "root_positions", "root_angles", "frame_numbers")
    motion = replace(motion, **{name: getattr(motion, name)[frames] for name in columns}, seen=None)
    shape = find_shape(motion.skeleton)
    flat = _project(scene_of(motion), shape)
    around = shape.radii[None, :, None]
    low, high = (flat[..., :2] - around).min(axis=1), (flat[..., :2] + around).max(axis=1)
    bottom = float(low[:, 1].min())
    scale = HEIGHT / max(float(high[:, 1].max()) - bottom, 0.25 * float((high - low)[:, 0].max()), 1e-9)
    flat, radii = scale * (flat - [0.0, bottom, 0.0]), scale * shape.radii
    left, right = scale * low[:, 0], scale * high[:, 0]
    step = max(float((right - left).max()) + GAP, 44.0)  # room for the time
    centres = MARGIN + step * (np.arange(len(frames)) + 0.5)
    width, height = int(np.ceil(2 * MARGIN + step * len(frames))), HEIGHT + 2 * MARGIN + 18
    floor = HEIGHT + MARGIN
    figures = [f'<path stroke="currentColor" stroke-width="1" opacity="0.3" d="M0 {floor}H{width}"/>']
    for pose, centre, middle, time in zip(flat, centres, (left + right) / 2.0, motion.times, strict=True):
        points = np.stack([pose[:, 0] - middle + centre, floor - pose[:, 1], pose[:, 2]], axis=1)
        figures.append(_figure(motion, shape, points, radii))
        figures.append(f'<text x="{centre:.0f}" y="{height - 6}" stroke="none">{time:.2f} s</text>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        f'role="img" style="max-width: 100%; height: auto"><title>{description}</title>'
        f'<g fill="currentColor" font-size="12" font-family="sans-serif" text-anchor="middle">{"".join(figures)}</g>'
        "</svg>"
    )


def _project(scene: Scene, shape: Shape) -> np.ndarray:
    """Centres of all spheres (n_frames, n_spheres, 3): right, up, near, from the side with the most movement.

    The motion goes to the right.
    """
    joints = scene.joints + [[0.0, 1.0, 0.0]] * scene.root[:, None]
    points = np.concatenate([scene.root[:, None] * [0.0, 1.0, 0.0], joints], axis=1)
    horizontal = points[..., [0, 2]]
    moved = horizontal - horizontal.mean(axis=0)
    if np.abs(moved).max() <= STILL * scene.size:
        moved = horizontal - horizontal.mean(axis=(0, 1))
    _, _, rows = np.linalg.svd(moved.reshape(-1, 2), full_matrices=False)
    direction = rows[0]
    travelled = (scene.root[-1] - scene.root[0])[[0, 2]] @ direction
    sign = travelled if abs(travelled) > 1e-9 * scene.size else direction[np.abs(direction).argmax()]
    direction = direction * np.sign(sign)
    points = shape.centres(points)
    horizontal = points[..., [0, 2]]
    return np.stack([horizontal @ direction, points[..., 1], horizontal @ [-direction[1], direction[0]]], axis=-1)


def _figure(motion: Motion, shape: Shape, points: np.ndarray, radii: np.ndarray) -> str:
    """The parts of one pose, far ones first."""
    side = [*sides(motion.skeleton.joint_names), ""]  # -1 is the root
    paths = []
    for part in sorted(shape.parts, key=lambda part: float(points[np.concatenate(part.hulls), 2].mean())):
        outlines = [
            outline(points[list(hull), :2], radii[list(hull)], [False] * len(hull), N_CORNERS).points
            for hull in part.hulls
        ]
        steps = (np.diff(np.rint(FINE * one).astype(int), axis=0, prepend=0).ravel() for one in outlines)
        lines = (f"M0 0m{' '.join(map(str, one)).replace(' -', '-')}z" for one in steps)
        paths.append(f'<path fill="{COLOURS[side[part.joint]]}" d="{"".join(lines)}"/>')
    return f'<g transform="scale({1 / FINE:g})">{"".join(paths)}</g>'
