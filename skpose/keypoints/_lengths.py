"""Lengths of bones from noisy positions, and whether they are constant."""

from typing import NamedTuple

import numpy as np

from skpose._utils.warnings import warn

OUTLIER = 4.0  # robust standard deviations from the median; of normal noise one length in 16,000 is as far
LARGEST_CORRECTION = 0.9  # of the square of the length, beyond which the bone is as short as the noise
STRETCH = 0.1  # of the length, slow change that is reported; a bending back changes by 0.08
CHANCE = 4.0  # standard deviations of a correlation by chance
UNCERTAIN = 0.05  # of the length, standard error that is reported
DIFFERENT = 0.1  # of the length, difference of the sides that is reported
FEW = 2  # frames from which a spread is known


class Length(NamedTuple):
    """The length of one bone, from all frames that show both ends."""

    value: float  # m
    error: float  # its standard error by noise, m; NaN from one frame
    stretch: float  # standard deviation of its slow change, m; zero if it may be chance


def bone_length(lengths: np.ndarray, weights: np.ndarray) -> Length:
    r"""The length of a bone from its lengths (n_frames,) in the frames; weights are zero if it is not seen.

    Noise at the ends makes the distance between them too long: with a variance σ² of the difference along each axis,
    the same in all directions, the squares q of the distances have the mean L² + 3σ² and the variance 4L²σ² + 6σ⁴.
    Together, L⁴ = mean(q)² − 1.5 var(q), without σ. Outliers are removed first.
    """
    seen = weights > 0.0
    d, w = lengths[seen], weights[seen] / weights[seen].max()
    median = np.median(d)
    kept = np.abs(d - median) <= OUTLIER * 1.4826 * np.median(np.abs(d - median)) + 1e-9 * median
    q, w = d[kept] ** 2, w[kept] / w[kept].sum()
    n = 1.0 / np.square(w).sum()  # frames of equal weight that would do as well
    if n < FEW * (1.0 - 1e-9) or not median > 0.0:
        return Length(float(np.sqrt(w @ q)), np.nan, 0.0)
    mean = w @ q
    variance = w @ np.square(q - mean) * n / (n - 1.0)
    value = (mean**2 - min(1.5 * variance, LARGEST_CORRECTION * mean**2)) ** 0.25
    # How much each frame moves the value: L⁴ = 2.5 mean(q)² − 1.5 mean(q²).
    influence = (5.0 * mean * (q - mean) - 1.5 * (q**2 - w @ q**2)) / (4.0 * value**3)
    error = np.sqrt(w @ np.square(influence) / (n - 1.0))
    return Length(float(value), float(error), _slow_change(lengths, seen, np.flatnonzero(seen)[kept]))


def _slow_change(lengths: np.ndarray, seen: np.ndarray, kept: np.ndarray) -> float:
    """The standard deviation of the change common to consecutive frames, which is not noise."""
    change = np.full(len(seen), np.nan)
    change[kept] = lengths[kept] - lengths[kept].mean()
    products = change[1:] * change[:-1]
    products = products[~np.isnan(products)]
    variance = np.square(change[kept]).mean()
    if not len(products) or products.mean() <= CHANCE / np.sqrt(len(products)) * variance:
        return 0.0
    return float(np.sqrt(products.mean()))


def symmetric_lengths(
    lengths: dict[str, Length], partner: dict[str, str], frames: dict[str, float]
) -> dict[str, Length]:
    """Replace lengths of left and right by their mean, weighted by frames; warn if they differ much."""
    found, apart = {}, []
    for name, length in lengths.items():
        other = lengths[partner[name]]
        share = frames[name] / (frames[name] + frames[partner[name]])
        value = share * length.value + (1.0 - share) * other.value
        error = float(np.hypot(share * length.error, (1.0 - share) * other.error))
        found[name] = Length(value, error if partner[name] != name else length.error, length.stretch)
        difference = abs(length.value - other.value)
        chance = np.nan_to_num(CHANCE * np.hypot(length.error, other.error))
        if length.value > other.value and difference > max(DIFFERENT * value, chance):
            apart.append(f"{name} {100.0 * length.value:.3g} cm, {partner[name]} {100.0 * other.value:.3g} cm")
    if apart:
        warn(
            f"left and right bones differ in length: {'; '.join(apart)}. With symmetric=True they have the mean length"
        )
    return found


def warn_of_lengths(lengths: dict[str, Length]) -> None:
    """Warn about bones that stretch, and about lengths lost in noise."""
    longest = max(length.value for length in lengths.values())
    stretched = {
        name: length.stretch / length.value
        for name, length in lengths.items()
        if length.stretch > STRETCH * max(length.value, 1e-3 * longest)
    }
    if stretched:
        warn(
            f"bones stretch: {_join(stretched, 'by ')} (standard deviation). Look for swapped or slipping points, "
            "wrong depth, two people"
        )
    uncertain = {
        name: length.error / length.value
        for name, length in lengths.items()
        if length.error > UNCERTAIN * length.value and name not in stretched
    }
    if uncertain:
        warn(
            f"lengths of bones are uncertain: {_join(uncertain, '±')} (standard error). Pass more frames, or "
            "layout.without([...])"
        )


def _join(shares: dict[str, float], sign: str) -> str:
    """The names with the largest shares, in %."""
    names = sorted(shares, key=lambda name: -shares[name])
    words = [f"{name} {sign}{100.0 * shares[name]:.2g} %" for name in names[:6]]
    return ", ".join(words) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
