"""Recordings of squats with natural variation, of which one may be wrong in a known way."""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from skpose import Motion
from skpose.datasets import humanoid
from skpose.geodesics import interpolate

SKELETON = humanoid()
RATE = 50.0  # Hz
DEEP = {"thigh_rx": -1.6, "shank_rx": 2.0, "foot_rx": -0.5, "upper_arm_rx": -1.3}  # rad, of both sides
CYCLE = (0.0, 0.0), (0.27, 0.5), (0.54, 1.0), (0.77, 0.5), (1.0, 0.0)  # share of the duration, share of the depth
DRIFT, SWAY = 0.015, 0.01  # rad: of each repetition as a whole, and of each joint in time
WRONG, FADE = (0.4, 0.6), 0.03  # share of the cycle in which the knee is in, and in which it gets there


def column(name):
    return SKELETON.dof_names.index(name)


def squats(seed, wrong=None, side="left", n=10, degrees=15.0, spread=1.0, method=None):
    """Return a recording of `n` squats, and when each begins and ends, s.

    Durations vary by 12 %, depths by 4 %, and so does the posture. In the repetition `wrong`, from 40 to 60 % of the
    cycle, a knee is in by so many degrees: the thigh, which points forward there, rotates about the vertical. The
    motion goes through its key poses as `interpolate` does it by a method; None is linear in the angles, and fast.
    """
    rng = np.random.default_rng(seed)
    deep = np.zeros(SKELETON.n_dofs)
    for name, angle in DEEP.items():
        deep[[column(f"{one}_{name}") for one in ("left", "right")]] = angle
    deep[column("abdomen_rx")] = 0.5
    keys, times, cycles, now = [np.zeros(SKELETON.n_dofs)], [0.0], [], 0.0
    for _ in range(n):
        start = now + 0.5 * np.exp(0.2 * rng.normal())
        duration = 2.0 * np.exp(0.12 * spread * rng.normal())
        depth, drift = 1.0 + 0.04 * spread * rng.normal(), DRIFT * spread * rng.normal(size=deep.shape)
        for when, share in CYCLE:
            when += 0.03 * spread * rng.normal() * (0.0 < when < 1.0)
            keys.append(share * (depth * deep + drift) + 0.5 * DRIFT * spread * rng.normal(size=deep.shape))
            times.append(start + when * duration)
        now = start + duration
        cycles.append((start, now))
    keys.append(np.zeros(SKELETON.n_dofs))
    times.append(now + 0.5)
    if method is None:
        frames = np.arange(0.0, times[-1], 1.0 / RATE)
        angles = np.stack([np.interp(frames, times, one) for one in np.transpose(keys)], axis=1)
    else:
        angles = interpolate(keys, times, SKELETON, frame_rate=RATE, method=method).angles
    sway = gaussian_filter1d(rng.normal(size=angles.shape), 0.1 * RATE, axis=0)
    angles = angles + SWAY * spread * sway / sway.std()
    if wrong is not None:
        first, last = cycles[wrong]
        phase = (np.arange(len(angles)) / RATE - first) / (last - first)
        edges = np.clip((phase - WRONG[0]) / FADE, 0.0, 1.0) * np.clip((WRONG[1] - phase) / FADE, 0.0, 1.0)
        angles[:, column(f"{side}_thigh_ry")] += {"left": -1, "right": 1}[side] * np.radians(degrees) * edges
    return Motion(SKELETON, angles, RATE), np.array(cycles)
