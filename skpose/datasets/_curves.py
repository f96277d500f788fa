"""Joint-angle curves of walking and running after published ones.

The curves have the shape, timing and peaks of the means of healthy adults in the sources below, drawn by hand to whole
degrees at every twentieth of the gait cycle. They cannot replace measurements. The rotation and lean of the
trunk, and the swing of the arms in running, are round figures of our own.

Sources
-------
Walking, legs: M. P. Kadaba, H. K. Ramakrishnan, M. E. Wootten, "Measurement of lower extremity kinematics during level
walking", J. Orthop. Res. 8, 1990, doi:10.1002/jor.1100080310.
Running, legs: T. F. Novacheck, "The biomechanics of running", Gait & Posture 7, 1998,
doi:10.1016/S0966-6362(97)00038-6.
Walking, arms: M. P. Murray, S. B. Sepic, E. J. Barnard, "Patterns of sagittal rotation of the upper limbs in walking",
Physical Therapy 47, 1967, doi:10.1093/ptj/47.4.272.
Running, elbows: A. K. Yegian, Y. Tucker, S. Gillinov, D. E. Lieberman, "Straight arm walking, bent arm running:
gait-specific elbow angles", J. Exp. Biol. 222, 2019, doi:10.1242/jeb.197228.
"""

from collections.abc import Sequence

import numpy as np

# Degrees at every twentieth of the cycle, which begins when the left foot strikes the ground; left side. The trunk's
# rotation is positive with the left shoulder back.
_N_POINTS = 20
CURVES = {
    "walk": {
        "hip_flexion": (30, 29, 26, 22, 16, 10, 4, -1, -6, -10, -11, -10, -4, 5, 15, 24, 30, 33, 33, 31),
        "hip_adduction": (0, 3, 6, 6, 5, 4, 4, 3, 2, 1, -1, -4, -6, -6, -5, -4, -3, -2, -1, -1),
        "knee_flexion": (5, 11, 17, 19, 17, 13, 9, 6, 5, 7, 13, 24, 39, 53, 60, 59, 49, 33, 16, 5),
        "ankle_dorsiflexion": (0, -5, -3, 2, 5, 7, 8, 9, 10, 10, 6, -4, -15, -18, -11, -4, 0, 1, 1, 1),
        "shoulder_flexion": (-24, -23, -20, -16, -11, -6, -1, 3, 6, 8, 8, 7, 4, 1, -4, -9, -14, -18, -21, -23),
        "elbow_flexion": (20, 20, 21, 22, 24, 27, 30, 33, 36, 38, 38, 37, 35, 32, 29, 26, 24, 22, 21, 20),
        "trunk_rotation": (5, 5, 4, 3, 2, 0, -2, -3, -4, -5, -5, -5, -4, -3, -2, 0, 2, 3, 4, 5),
        "trunk_lean": (3,) * _N_POINTS,
    },
    "run": {
        "hip_flexion": (42, 40, 36, 30, 22, 13, 4, -4, -8, -8, -3, 6, 18, 30, 41, 49, 53, 53, 50, 46),
        "hip_adduction": (2, 6, 9, 10, 8, 5, 1, -3, -5, -6, -5, -3, -2, -1, -1, -1, -1, 0, 0, 1),
        "knee_flexion": (22, 33, 42, 45, 42, 35, 27, 21, 22, 34, 54, 74, 89, 95, 92, 80, 61, 40, 24, 18),
        "ankle_dorsiflexion": (5, 12, 20, 25, 25, 19, 7, -9, -21, -21, -14, -7, -2, 1, 2, 3, 4, 5, 5, 5),
        "shoulder_flexion": (-45, -44, -40, -33, -25, -16, -7, 2, 9, 13, 15, 14, 10, 4, -5, -14, -23, -32, -39, -44),
        "elbow_flexion": (88, 88, 86, 84, 82, 81, 82, 85, 89, 93, 96, 97, 97, 96, 94, 93, 92, 91, 90, 89),
        "trunk_rotation": (13, 13, 11, 8, 4, 0, -4, -8, -11, -13, -13, -13, -11, -8, -4, 0, 4, 8, 11, 13),
        "trunk_lean": (9,) * _N_POINTS,
    },
}
_N_HARMONICS = 6  # higher ones contain only the rounding to whole degrees

# The dofs that follow a curve: their names, factors, and lags in cycles. The right limbs are half a cycle behind.
DOFS: dict[str, tuple[tuple[str, float, float], ...]] = {
    "hip_flexion": (("left_thigh_rx", -1, 0), ("right_thigh_rx", -1, 0.5)),
    "hip_adduction": (("left_thigh_rz", -1, 0), ("right_thigh_rz", 1, 0.5)),
    "knee_flexion": (("left_shank_rx", 1, 0), ("right_shank_rx", 1, 0.5)),
    "ankle_dorsiflexion": (("left_foot_rx", -1, 0), ("right_foot_rx", -1, 0.5)),
    "shoulder_flexion": (("left_upper_arm_rx", -1, 0), ("right_upper_arm_rx", -1, 0.5)),
    "elbow_flexion": (("left_forearm_rx", -1, 0), ("right_forearm_rx", -1, 0.5)),
    "trunk_rotation": (("abdomen_ry", 0.5, 0), ("chest_ry", 0.5, 0)),
    "trunk_lean": (("abdomen_rx", 0.5, 0), ("chest_rx", 0.5, 0)),
}


def series_of(points: Sequence[float]) -> np.ndarray:
    """The Fourier coefficients c_0 … c_H of a curve in degrees: f(t) = Re Σ c_k exp(2πi k t)."""
    coefficients = np.fft.rfft(points)[: _N_HARMONICS + 1] / len(points)
    coefficients[1:] *= 2.0
    return coefficients


def evaluate(series: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """The values of a Fourier series at phases in cycles."""
    return (np.exp(2j * np.pi * np.outer(phase, np.arange(len(series)))) @ series).real
