"""Joint angles, symmetry and gait.

| module             | content                                                                             |
|--------------------|-------------------------------------------------------------------------------------|
| `_joint_angles`    | flexion, adduction, rotation; their cycles, such as strides, over per cent          |
| `_segments`        | the joints of a person, the segments between them, and which of them positions show |
| `_measure`         | formulas of angles, axes of segments, and the pose in which angles are zero         |
| `_symmetry`        | the left against the mirrored right, joint by joint                                 |
| `_gait_events`     | foot contacts and foot offs, from positions                                         |
| `_gait_parameters` | cadence, lengths of steps, shares of stance                                         |
"""

from skpose.biomechanics._gait_events import GaitEvents as GaitEvents, gait_events
from skpose.biomechanics._gait_parameters import GaitParameters as GaitParameters, gait_parameters
from skpose.biomechanics._joint_angles import JointAngles as JointAngles, joint_angles
from skpose.biomechanics._symmetry import JointAsymmetry as JointAsymmetry, SymmetryResult as SymmetryResult, symmetry

__all__ = ["gait_events", "gait_parameters", "joint_angles", "symmetry"]
