"""Key poses of ten actions, of our own: what a person does with trunk, arms and feet, and when.

Angles in degrees. Lengths are in lengths of the leg, from hip to ankle, so that people of any size do the same.
Everybody uses the right hand, steps and swings with the right foot first, and turns to the left.
"""

from collections.abc import Mapping
from typing import NamedTuple


class Arm(NamedTuple):
    """One arm."""

    raised: float = 8.0  # of the upper arm, from hanging
    plane: float = 75.0  # in which it is raised: 0 in front, 90 at the side, 180 behind
    inward: float = 0.0  # rotation of the upper arm about itself, which a bent forearm follows
    elbow: float = 15.0  # flexion


class Foot(NamedTuple):
    """One foot: where its ankle is if the foot is flat, from where it is when the person stands at the beginning."""

    forward: float = 0.0
    up: float = 0.0
    left: float = 0.0
    heel: float = 0.0  # by which the foot is rotated about its ball, heel up; negative: toes up
    outward: float = 7.0  # rotation about the vertical
    stands: bool = True  # on its ball at least


class Key(NamedTuple):
    """A key pose. The pelvis is where it is with straight legs at the beginning, but for these."""

    time: float  # share of the duration
    down: float = 0.004
    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0  # of the pelvis, to the left
    tilt: float = 0.0  # forward
    lean: float = 0.0  # of the trunk on the pelvis, forward
    twist: float = 0.0  # to the left
    bend: float = 0.0  # to the right
    nod: float = 0.0  # of neck and head on the trunk, forward
    right_arm: Arm = Arm()
    left_arm: Arm = Arm()
    right_foot: Foot = Foot()
    left_foot: Foot = Foot()
    sits: bool = False  # so that the height of the pelvis is that of the seat


class Action(NamedTuple):
    """An action."""

    duration: float  # s
    keys: tuple[Key, ...]


GUARD, BALANCE = Arm(35, 40, 20, 60), Arm(35, 150, 0, 30)
HOLDING = Arm(18, 5, 15, 80)
OVER_HEAD = Arm(150, 12, 0, 20)
WAVING = {"raised": 72.0, "plane": 70.0, "inward": -80.0}
STEP, HIGH = 0.42, 0.26  # of the step: where it is, and how high
# Someone who turns by half a turn around the middle between the feet.
HALF_LEFT, HALF_RIGHT = Foot(-0.19, 0, -0.14, 0, 82), Foot(0, 0, 0.389, 0, -173)


def _turned(time: float, turn: float, left: Foot, right: Foot, side: float = 0.0) -> Key:
    arm = Arm(14, 60, 10, 25)
    return Key(time, 0.02, 0, side, turn, 0, 2, 8, 0, 0, arm, arm, right, left)


ACTIONS: Mapping[str, Action] = {
    "jump": Action(
        1.6,
        (
            Key(0.0),
            Key(0.27, 0.30, -0.10, tilt=25, lean=25, nod=-20, right_arm=Arm(35, 165), left_arm=Arm(35, 165)),
            Key(
                0.47, -0.09, 0.04, lean=-5, right_arm=Arm(80, 10), left_arm=Arm(80, 10),
                right_foot=Foot(heel=45), left_foot=Foot(heel=45),
            ),
            Key(
                0.61, -0.30, 0.06, right_arm=Arm(140, 15), left_arm=Arm(140, 15),
                right_foot=Foot(0.05, 0.28, heel=35, stands=False), left_foot=Foot(0.05, 0.28, heel=35, stands=False),
            ),
            Key(
                0.75, -0.02, 0.05, tilt=5, lean=10, right_arm=Arm(75, 25), left_arm=Arm(75, 25),
                right_foot=Foot(0.08, heel=20), left_foot=Foot(0.08, heel=20),
            ),
            Key(
                0.85, 0.24, -0.02, tilt=20, lean=20, nod=-15, right_arm=Arm(40, 30), left_arm=Arm(40, 30),
                right_foot=Foot(0.08), left_foot=Foot(0.08),
            ),
            Key(1.0, 0.004, 0.08, right_foot=Foot(0.08), left_foot=Foot(0.08)),
        ),
    ),
    "kick": Action(
        1.8,
        (
            Key(0.0),
            Key(
                0.28, 0.03, 0.0, 0.10, -5, -2, lean=5, right_arm=BALANCE, left_arm=GUARD,
                right_foot=Foot(0.22, 0.42, 0.03, 20, stands=False),
            ),
            Key(
                0.43, 0.02, 0.04, 0.10, 10, -15, lean=10, twist=-10, nod=5, right_arm=BALANCE, left_arm=Arm(60, 20, 20, 45),
                right_foot=Foot(0.97, 0.75, 0.06, -55, stands=False),
            ),
            Key(
                0.60, 0.03, 0.0, 0.10, -5, -2, lean=5, right_arm=BALANCE, left_arm=GUARD,
                right_foot=Foot(0.24, 0.40, 0.03, 15, stands=False),
            ),
            Key(0.80, 0.02, 0.0, 0.03, right_arm=Arm(15, 60, 0, 25), left_arm=Arm(15, 60, 0, 25)),
            Key(1.0),
        ),
    ),
    "lift": Action(
        2.8,
        (
            Key(0.0),
            Key(0.36, 0.38, -0.20, tilt=38, lean=20, nod=-20, right_arm=Arm(75, -6, 0, 8), left_arm=Arm(75, -6, 0, 8)),
            Key(0.46, 0.38, -0.20, tilt=38, lean=20, nod=-15, right_arm=Arm(75, -10, 0, 8), left_arm=Arm(75, -10, 0, 8)),
            Key(0.64, 0.20, -0.15, tilt=30, lean=15, nod=-10, right_arm=Arm(50, -6, 10, 30), left_arm=Arm(50, -6, 10, 30)),
            Key(0.84, 0.004, -0.02, lean=-5, right_arm=HOLDING, left_arm=HOLDING),
            Key(1.0, lean=-5, right_arm=HOLDING, left_arm=HOLDING),
        ),
    ),
    "reach": Action(
        2.1,
        (
            Key(0.0),
            Key(0.25, 0.004, 0.01, nod=-8, right_arm=Arm(70, 10, 0, 45)),
            Key(
                0.47, -0.05, 0.08, -0.02, 8, lean=-4, twist=8, bend=-8, nod=-20, right_arm=OVER_HEAD,
                right_foot=Foot(heel=18), left_foot=Foot(heel=18),
            ),
            Key(
                0.58, -0.05, 0.08, -0.02, 8, lean=-4, twist=8, bend=-8, nod=-20, right_arm=OVER_HEAD,
                right_foot=Foot(heel=18), left_foot=Foot(heel=18),
            ),
            Key(0.80, 0.004, 0.01, right_arm=Arm(60, 15, 10, 60)),
            Key(1.0),
        ),
    ),
    "sit down": Action(
        2.2,
        (
            Key(0.0),
            Key(0.35, 0.12, -0.18, tilt=25, lean=20, nod=-10, right_arm=Arm(30, 20), left_arm=Arm(30, 20)),
            Key(0.70, sits=True, down=0.46, forward=-0.43, tilt=20, lean=22, nod=-15, right_arm=Arm(40, 5, 0, 30), left_arm=Arm(40, 5, 0, 30)),
            Key(0.86, sits=True, down=0.46, forward=-0.45, tilt=-4, lean=6, right_arm=Arm(24, 5, 10, 48), left_arm=Arm(24, 5, 10, 48)),
            Key(1.0, sits=True, down=0.46, forward=-0.45, tilt=-6, lean=6, right_arm=Arm(20, 5, 10, 50), left_arm=Arm(20, 5, 10, 50)),
        ),
    ),
    "squat": Action(
        1.6,
        (
            Key(0.0),
            Key(0.25, 0.20, -0.12, tilt=18, lean=12, nod=-8, right_arm=Arm(62, 8), left_arm=Arm(62, 8)),
            Key(0.50, 0.44, -0.19, tilt=25, lean=22, nod=-20, right_arm=Arm(112, 8), left_arm=Arm(112, 8)),
            Key(0.75, 0.20, -0.12, tilt=18, lean=12, nod=-8, right_arm=Arm(62, 8), left_arm=Arm(62, 8)),
            Key(1.0),
        ),
    ),
    "step up": Action(
        2.2,
        (
            Key(0.0),
            Key(
                0.22, 0.02, 0.04, 0.10, tilt=3, lean=6, right_arm=Arm(12, 150, 0, 20), left_arm=Arm(22, 10, 0, 30),
                right_foot=Foot(0.22, 0.36, heel=10, stands=False),
            ),
            Key(
                0.40, 0.04, 0.14, 0.04, tilt=6, lean=10, right_arm=Arm(15, 150, 0, 20), left_arm=Arm(25, 10, 0, 30),
                right_foot=Foot(STEP, HIGH), left_foot=Foot(heel=12),
            ),
            Key(
                0.66, -0.18, 0.38, -0.08, tilt=8, lean=8, right_arm=Arm(25, 10, 0, 30), left_arm=Arm(15, 150, 0, 20),
                right_foot=Foot(STEP, HIGH), left_foot=Foot(0.12, 0.20, heel=45, stands=False),
            ),
            Key(
                0.82, -0.24, 0.42, -0.06, lean=3, right_arm=Arm(15, 40), left_arm=Arm(12, 100),
                right_foot=Foot(STEP, HIGH), left_foot=Foot(0.40, 0.42, heel=10, stands=False),
            ),
            Key(1.0, 0.004 - HIGH, STEP, right_foot=Foot(STEP, HIGH), left_foot=Foot(STEP, HIGH)),
        ),
    ),
    "throw": Action(
        2.0,
        (
            Key(0.0),
            Key(
                0.32, 0.04, -0.03, -0.10, -30, -3, -4, -30, 5, right_arm=Arm(88, 105, -75, 95), left_arm=Arm(70, 15, 20, 25),
                left_foot=Foot(0.15, 0.14, heel=15, stands=False),
            ),
            Key(
                0.47, 0.06, 0.18, -0.02, -15, 0, 0, -25, 0, right_arm=Arm(95, 100, -90, 95), left_arm=Arm(75, 25, 20, 20),
                left_foot=Foot(0.45), right_foot=Foot(outward=35),
            ),
            Key(
                0.57, 0.07, 0.28, 0.02, 15, 5, 10, 15, -8, right_arm=Arm(135, 35, -20, 25), left_arm=Arm(40, 60, 0, 45),
                left_foot=Foot(0.45), right_foot=Foot(outward=35, heel=28),
            ),
            Key(
                0.68, 0.09, 0.34, 0.04, 25, 12, 25, 28, 5, right_arm=Arm(55, -25, 30, 20), left_arm=Arm(30, 120, 0, 40),
                left_foot=Foot(0.45), right_foot=Foot(outward=35, heel=42),
            ),
            Key(
                0.84, 0.04, 0.42, 0.02, 5, 3, 8, 8, 0, right_arm=Arm(20, 20, 10, 25), left_arm=Arm(15, 75, 0, 25),
                left_foot=Foot(0.45), right_foot=Foot(0.25, 0.08, heel=20, stands=False),
            ),
            Key(1.0, 0.004, 0.45, left_foot=Foot(0.45), right_foot=Foot(0.45)),
        ),
    ),
    "turn": Action(
        2.2,
        (
            Key(0.0),
            _turned(0.18, 25, Foot(-0.08, 0.08, -0.05, 15, 45, stands=False), Foot(), -0.08),
            _turned(0.34, 65, HALF_LEFT, Foot(heel=15, outward=-10)),
            _turned(0.54, 115, HALF_LEFT, Foot(0.14, 0.10, 0.20, 20, -100, stands=False), 0.04),
            _turned(0.70, 150, HALF_LEFT, HALF_RIGHT, -0.02)._replace(left_foot=HALF_LEFT._replace(heel=12)),
            _turned(0.86, 172, Foot(-0.10, 0.08, -0.28, 15, 150, stands=False), HALF_RIGHT, 0.08),
            Key(1.0, turn=180, left_foot=Foot(0, 0, -0.389, 0, 187), right_foot=HALF_RIGHT),
        ),
    ),
    "wave": Action(
        2.8,
        (
            Key(0.0),
            Key(0.20, nod=-4, bend=-3, right_arm=Arm(**WAVING, elbow=80)),
            Key(0.31, nod=-4, bend=-3, right_arm=Arm(**WAVING, elbow=55)),
            Key(0.42, nod=-4, bend=-3, right_arm=Arm(**WAVING, elbow=110)),
            Key(0.53, nod=-4, bend=-3, right_arm=Arm(**WAVING, elbow=55)),
            Key(0.64, nod=-4, bend=-3, right_arm=Arm(**WAVING, elbow=110)),
            Key(0.77, nod=-4, bend=-3, right_arm=Arm(**WAVING, elbow=65)),
            Key(1.0),
        ),
    ),
}  # fmt: skip
