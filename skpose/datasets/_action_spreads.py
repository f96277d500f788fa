"""Differences between people who do the same thing, and between repetitions by one person, as measured.

The figures are what ``python benchmarks/action_spreads.py HDM05`` prints, which explains the method: 174 recordings of
ten actions by three people, put on the joints of the humanoid; variance components by REML. They are standard
deviations with 20 degrees of freedom between people and 144 within. What a person does in all actions is no part of
them: `POSTURE` has that, measured on more people.

They include what markers and skeleton files contribute. ``foot_rz``, the roll of the foot, has the figure of the files'
second dof of the foot, its rotation about the shank. Clavicles never move in the files.
"""

from typing import NamedTuple


class Execution(NamedTuple):
    """Standard deviations of a dof within an action, degrees, about the joint's own axes."""

    person: float  # of a person in this action, all the time
    person_key: float  # of a person in this action, at one of its phases
    recording: float  # of one of the person's repetitions, all the time
    recording_key: float  # of one of the person's repetitions, at one of its phases


EXECUTION = {
    "abdomen_rx": Execution(4.2, 2.9, 2.9, 3.4),
    "abdomen_ry": Execution(1.7, 1.3, 1.3, 1.5),
    "abdomen_rz": Execution(1.9, 1.8, 2.2, 2.2),
    "chest_rx": Execution(2.9, 1.5, 2.2, 2.5),
    "chest_ry": Execution(2.8, 1.8, 2.1, 2.3),
    "chest_rz": Execution(2.2, 2.2, 1.7, 2.2),
    "neck_rx": Execution(5.1, 2.4, 3.0, 3.1),
    "neck_ry": Execution(2.7, 1.6, 1.7, 1.9),
    "neck_rz": Execution(3.6, 1.4, 2.1, 1.8),
    "head_rx": Execution(5.3, 3.6, 5.5, 5.2),
    "head_ry": Execution(5.1, 3.4, 3.5, 3.6),
    "head_rz": Execution(7.4, 3.7, 4.2, 4.6),
    "thigh_rx": Execution(4.0, 5.1, 4.4, 6.6),
    "thigh_ry": Execution(4.3, 4.8, 3.0, 5.4),
    "thigh_rz": Execution(3.4, 4.2, 4.6, 6.6),
    "shank_rx": Execution(3.5, 5.7, 7.3, 9.3),
    "foot_rx": Execution(4.9, 7.5, 10.1, 17.4),
    "foot_rz": Execution(14.9, 5.9, 12.0, 9.9),
    "toes_rx": Execution(5.2, 4.8, 6.5, 5.9),
    "clavicle_ry": Execution(0.0, 0.0, 0.0, 0.0),
    "clavicle_rz": Execution(0.0, 0.0, 0.0, 0.0),
    "upper_arm_rx": Execution(6.5, 6.0, 7.3, 8.0),
    "upper_arm_ry": Execution(21.0, 8.2, 12.3, 12.6),
    "upper_arm_rz": Execution(6.8, 4.8, 3.8, 5.1),
    "forearm_rx": Execution(13.7, 6.0, 8.8, 10.8),
    "hand_rx": Execution(5.9, 3.1, 5.4, 4.5),
    "hand_rz": Execution(9.9, 4.4, 5.4, 4.3),
}
# Of a person in an action, and of one repetition: of the logarithm of its duration; of the share of its duration by
# which it is late in the middle.
TEMPO = (0.114, 0.162)
TIMING = (0.044, 0.065)
