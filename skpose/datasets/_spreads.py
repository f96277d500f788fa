"""Differences of posture and style between people, and between recordings of one person, as measured.

The figures are what ``python benchmarks/spreads.py CMU --hdm05 HDM05`` prints, which explains the method: 50 recordings
of eight people (28 walks and 12 runs of five in CMU, ten jogs of three in HDM05), put on the joints of the humanoid;
variance components by REML, so that the spread over recordings is no part of the one over people. They are standard
deviations with 6 degrees of freedom: the true one is between 0.64 and 2.2 times the figure (95 %), and a correlation of
independent dofs would be within ±0.75.

They include what a person's markers and skeleton file contribute, not posture alone: hands, heads and twists of upper
arms differ most. The rotations of some joints of the trunk go together (r = 1) because the software that made the files
distributed one rotation over several joints.

Two dofs have no counterpart in the files: ``foot_rz``, the roll of the foot, has the figure of the files' second dof of
the foot, its rotation about the shank. Clavicles never move in the files; what they would do is in the upper arms.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from skpose.datasets._humanoid import PARENTS


class Spread(NamedTuple):
    """Standard deviations of a dof's mean, degrees."""

    shared: float  # over people, of the part that both sides share; in the trunk of the whole
    apart: float  # over people, of the part by which a person's left and right differ from it, in opposite directions
    recording: float  # over the recordings of one person, of one side
    shared_r: float = 0.0  # correlation with the same part of the joint before, about the same axis
    apart_r: float = 0.0

    @property
    def people(self) -> float:
        """Over people, of one side."""
        return float(np.hypot(self.shared, self.apart))


# The dofs of neighbouring joints about the same axis are correlated more than those of independent people,
# and so are the two sides of a person; the dofs of one joint are not.
POSTURE = {
    "abdomen_rx": Spread(6.9, 0.0, 1.0),
    "abdomen_ry": Spread(1.2, 0.0, 0.3),
    "abdomen_rz": Spread(0.6, 0.0, 1.3),
    "chest_rx": Spread(5.8, 0.0, 1.3, -0.71),
    "chest_ry": Spread(2.3, 0.0, 0.8, 1.00),
    "chest_rz": Spread(2.5, 0.0, 0.6, -0.24),
    "neck_rx": Spread(5.3, 0.0, 1.1),
    "neck_ry": Spread(5.8, 0.0, 1.2, -0.02),
    "neck_rz": Spread(7.2, 0.0, 0.7, -0.89),
    "head_rx": Spread(14.1, 0.0, 4.7, -0.68),
    "head_ry": Spread(12.4, 0.0, 2.7, 1.00),
    "head_rz": Spread(10.7, 0.0, 1.8, -0.89),
    "thigh_rx": Spread(5.6, 1.7, 1.9),
    "thigh_ry": Spread(2.7, 2.3, 1.2),
    "thigh_rz": Spread(1.4, 2.4, 1.2),
    "shank_rx": Spread(5.6, 2.2, 2.9, -0.54, -0.95),
    "foot_rx": Spread(4.7, 1.7, 2.3, 0.10, -0.80),
    "foot_rz": Spread(4.9, 4.0, 1.7),
    "toes_rx": Spread(4.9, 4.1, 2.8, 0.54, -0.52),
    "clavicle_ry": Spread(0.0, 0.0, 0.0),
    "clavicle_rz": Spread(0.0, 0.0, 0.0),
    "upper_arm_rx": Spread(8.3, 3.3, 1.9),
    "upper_arm_ry": Spread(8.7, 5.9, 3.9),
    "upper_arm_rz": Spread(3.7, 2.9, 2.0),
    "forearm_rx": Spread(5.8, 5.5, 4.4, -0.97, -0.69),
    "hand_rx": Spread(5.3, 17.3, 3.1, 0.39, -0.61),
    "hand_rz": Spread(9.1, 6.4, 3.4),
}
# Spreads over people of the logarithm of a curve's amplitude, and of its phase after the hip's, cycles.
STYLE = {
    "hip_flexion": (0.13, 0.000),
    "hip_adduction": (0.32, 0.030),
    "knee_flexion": (0.13, 0.038),
    "ankle_dorsiflexion": (0.04, 0.067),
    "shoulder_flexion": (0.31, 0.048),
    "elbow_flexion": (0.41, 0.048),
    "trunk_rotation": (0.39, 0.020),
}


def mirror(dof: str) -> float:
    """Return the sign of a dof's angle on the other side: x points there, so that a mirror keeps rotations about x."""
    return 1.0 if dof.endswith("x") else -1.0


def posture_of_person(rng: np.random.RandomState, dof_names: Sequence[str]) -> np.ndarray:
    """Draw a person's deviation (n_dofs,) from the mean posture, degrees."""
    shared, apart = (
        _along_the_limbs(rng, {key: getattr(spread, f"{part}_r") for key, spread in POSTURE.items()})
        for part in ("shared", "apart")
    )
    posture: dict[str, float] = {}
    for key, spread in POSTURE.items():
        both, other = spread.shared * shared[key], spread.apart * apart[key]
        posture |= {key: both, f"left_{key}": both + other, f"right_{key}": mirror(key) * (both - other)}
    return np.array([posture[name] for name in dof_names])


def _along_the_limbs(rng: np.random.RandomState, r: Mapping[str, float]) -> dict[str, float]:
    """Draw a standard normal number for each dof, correlated with that of the same axis of the joint before."""
    drawn: dict[str, float] = {}
    for key, correlation in r.items():
        before = drawn.get(f"{PARENTS[key[:-3]]}{key[-3:]}", 0.0)
        drawn[key] = correlation * before + np.sqrt(1.0 - correlation**2) * rng.standard_normal()
    return drawn


def posture_of_recording(rng: np.random.RandomState, dof_names: Sequence[str]) -> np.ndarray:
    """Draw a recording's deviation (n_dofs,) from the person's posture, degrees."""
    spread = [POSTURE[name.removeprefix("left_").removeprefix("right_")].recording for name in dof_names]
    return np.array(spread) * rng.standard_normal(len(dof_names))


def style_of_person(rng: np.random.RandomState) -> dict[str, tuple[float, float]]:
    """Draw a person's factor of the amplitude and shift of the phase, cycles, of every curve."""
    return {
        curve: (float(np.exp(amplitude * rng.standard_normal())), phase * rng.standard_normal())
        for curve, (amplitude, phase) in STYLE.items()
    }
