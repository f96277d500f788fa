"""Movements of people in the words of those who measure them: angles of joints, symmetry, gait.

| module             |                                                                                             |
|--------------------|---------------------------------------------------------------------------------------------|
| `_joint_angles`    | flexion, adduction, rotation; `_measure` measures each joint, by the formulas of `_angles`  |
| `_segments`        | the segments of a person and how they are turned; `_axes` has their axes where they stand   |
| `_seen`            | what of the segments is shown by the positions to which a motion was fitted                 |
| `_zero`            | the pose in which angles are zero, and whether a person stands in it; `_person` has joints  |
| `_symmetry`        | the left against the mirrored right, joint by joint                                         |
| `_gait_events`     | when the feet come down and leave the floor; `_steps` finds it from positions               |
| `_gait_parameters` | cadence, lengths of steps, shares of stance                                                 |
| `_feet`            | the joints of hips and feet, where they are in the world, where they travel                 |
| `_recordings`      | whether two results are of one recording                                                    |
| `_tables`          | tables of pandas                                                                            |
"""

from skpose.biomechanics._gait_events import GaitEvents, gait_events
from skpose.biomechanics._gait_parameters import GaitParameter, GaitParameters, gait_parameters
from skpose.biomechanics._joint_angles import JointAngles, joint_angles
from skpose.biomechanics._symmetry import JointAsymmetry, SymmetryResult, symmetry

__all__ = [
    "GaitEvents",
    "GaitParameter",
    "GaitParameters",
    "JointAngles",
    "JointAsymmetry",
    "SymmetryResult",
    "gait_events",
    "gait_parameters",
    "joint_angles",
    "symmetry",
]
