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
    """The parts of one pose, far ones first; successive parts of one side are one path."""
    side = sides(motion.skeleton.joint_names)
    order = sorted(shape.parts, key=lambda part: float(np.mean([points[i, 2] for hull in part.hulls for i in hull])))
    found: list[list[str]] = []
    for part in order:
        name = side[part.joint] if part.joint >= 0 else ""
        if not found or found[-1][0] != name:
            found.append([name])
        for hull in part.hulls:
            corners = outline(points[list(hull), :2], radii[list(hull)], [False] * len(hull), 16).points
            corners = np.rint(FINE * corners).astype(int)
            steps = np.diff(corners, axis=0)
            steps = steps[steps.any(axis=1)]
            first, line = (" ".join(map(str, each.ravel())).replace(" -", "-") for each in (corners[0], steps))
            found[-1].append(f"M{first}l{line}z")
    paths = (f'<path fill="{COLOURS[name]}" d="{"".join(d)}"/>' for name, *d in found)
    return f'<g transform="scale({1 / FINE:g})">{"".join(paths)}</g>'
