"""Key poses of ten actions, of our own: what a person does with trunk, arms and feet, and when.

Angles in degrees. Lengths are in lengths of the leg, from hip to ankle, so that people of any size do the same.
Everybody uses the right hand, steps and swings with the right foot first, and turns to the left.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple


class Arm(NamedTuple):
    """One arm."""

    raised: float = 8.0  # of the upper arm, from hanging
    plane: float = 75.0  # in which it is raised: 0 in front, 90 at the side, 180 behind
    inward: float = 0.0  # rotation of the upper arm about itself, which a bent forearm follows
    elbow: float = 15.0  # flexion


class Foot(NamedTuple):
    """One foot: the position of its ankle if the foot is flat, relative to standing at the beginning."""

    forward: float = 0.0
    up: float = 0.0
    left: float = 0.0
    heel: float = 0.0  # by which the foot is rotated about its ball, heel up; negative: toes up
    outward: float = 7.0  # rotation about the vertical
    stands: bool = True  # on its ball at least


class Key(NamedTuple):
    """A key pose; the pelvis relative to standing with straight legs at the beginning."""

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
    sits: bool = False  # the seat gives the height of the pelvis


class Action(NamedTuple):
    """An action."""

    duration: float  # s
    keys: tuple[Key, ...]


def arms(arm: Arm) -> dict[str, Any]:
    """Both arms of a key pose, mirrored."""
    return {"right_arm": arm, "left_arm": arm}


def feet(foot: Foot) -> dict[str, Any]:
    """Both feet."""
    return {"right_foot": foot, "left_foot": foot}


GUARD, BALANCE = Arm(35, 40, 20, 60), Arm(35, 150, 0, 30)
HOLDING, OVER_HEAD, WAVE = Arm(18, 5, 15, 80), Arm(150, 12, 0, 20), Arm(72, 70, -80)
STEP, HIGH = 0.42, 0.26  # of the step: distance and height
ON_STEP = Foot(STEP, HIGH)
# Of someone who turns by half a turn around the middle between the feet: the left first, then the right.
HALF_LEFT, HALF_RIGHT = Foot(-0.19, 0, -0.14, 0, 82), Foot(0, 0, 0.389, 0, -173)

ACTIONS: Mapping[str, Action] = {
    "jump": Action(
        1.6,
        (
            Key(0),
            Key(0.27, down=0.3, forward=-0.1, tilt=25, lean=25, nod=-20, **arms(Arm(35, 165))),
            Key(0.47, down=-0.09, forward=0.04, lean=-5, **arms(Arm(80, 10)), **feet(Foot(heel=45))),
            Key(
                0.61, down=-0.3, forward=0.06, **arms(Arm(140, 15)),
                **feet(Foot(forward=0.05, up=0.28, heel=35, stands=False)),
            ),
            Key(
                0.75, down=-0.02, forward=0.05, tilt=5, lean=10, **arms(Arm(75, 25)),
                **feet(Foot(forward=0.08, heel=20)),
            ),
            Key(
                0.85, down=0.24, forward=-0.02, tilt=20, lean=20, nod=-15, **arms(Arm(40, 30)),
                **feet(Foot(forward=0.08)),
            ),
            Key(1, forward=0.08, **feet(Foot(forward=0.08))),
        ),
    ),
    "kick": Action(
        1.8,
        (
            Key(0),
            Key(
                0.28, down=0.03, left=0.1, turn=-5, tilt=-2, lean=5, right_arm=BALANCE, left_arm=GUARD,
                right_foot=Foot(forward=0.22, up=0.42, left=0.03, heel=20, stands=False),
            ),
            Key(
                0.43, down=0.02, forward=0.04, left=0.1, turn=10, tilt=-15, lean=10, twist=-10, nod=5,
                right_arm=BALANCE, left_arm=Arm(60, 20, 20, 45),
                right_foot=Foot(forward=0.97, up=0.75, left=0.06, heel=-55, stands=False),
            ),
            Key(
                0.6, down=0.03, left=0.1, turn=-5, tilt=-2, lean=5, right_arm=BALANCE, left_arm=GUARD,
                right_foot=Foot(forward=0.24, up=0.4, left=0.03, heel=15, stands=False),
            ),
            Key(0.8, down=0.02, left=0.03, **arms(Arm(15, 60, 0, 25))),
            Key(1),
        ),
    ),
    "lift": Action(
        2.8,
        (
            Key(0),
            Key(0.36, down=0.38, forward=-0.2, tilt=38, lean=20, nod=-20, **arms(Arm(75, -6, 0, 8))),
            Key(0.46, down=0.38, forward=-0.2, tilt=38, lean=20, nod=-15, **arms(Arm(75, -10, 0, 8))),
            Key(0.64, down=0.2, forward=-0.15, tilt=30, lean=15, nod=-10, **arms(Arm(50, -6, 10, 30))),
            Key(0.84, forward=-0.02, lean=-5, **arms(HOLDING)),
            Key(1, lean=-5, **arms(HOLDING)),
        ),
    ),
    "reach": Action(
        2.1,
        (
            Key(0),
            Key(0.25, forward=0.01, nod=-8, right_arm=Arm(70, 10, 0, 45)),
            Key(
                0.47, down=-0.05, forward=0.08, left=-0.02, turn=8, lean=-4, twist=8, bend=-8, nod=-20,
                right_arm=OVER_HEAD, **feet(Foot(heel=18)),
            ),
            Key(
                0.58, down=-0.05, forward=0.08, left=-0.02, turn=8, lean=-4, twist=8, bend=-8, nod=-20,
                right_arm=OVER_HEAD, **feet(Foot(heel=18)),
            ),
            Key(0.8, forward=0.01, right_arm=Arm(60, 15, 10, 60)),
            Key(1),
        ),
    ),
    "sit down": Action(
        2.2,
        (
            Key(0),
            Key(0.35, down=0.12, forward=-0.18, tilt=25, lean=20, nod=-10, **arms(Arm(30, 20))),
            Key(0.7, down=0.46, forward=-0.43, tilt=20, lean=22, nod=-15, sits=True, **arms(Arm(40, 5, 0, 30))),
            Key(0.86, down=0.46, forward=-0.45, tilt=-4, lean=6, sits=True, **arms(Arm(24, 5, 10, 48))),
            Key(1, down=0.46, forward=-0.45, tilt=-6, lean=6, sits=True, **arms(Arm(20, 5, 10, 50))),
        ),
    ),
    "squat": Action(
        1.6,
        (
            Key(0),
            Key(0.25, down=0.2, forward=-0.12, tilt=18, lean=12, nod=-8, **arms(Arm(62, 8))),
            Key(0.5, down=0.44, forward=-0.19, tilt=25, lean=22, nod=-20, **arms(Arm(112, 8))),
            Key(0.75, down=0.2, forward=-0.12, tilt=18, lean=12, nod=-8, **arms(Arm(62, 8))),
            Key(1),
        ),
    ),
    "step up": Action(
        2.2,
        (
            Key(0),
            Key(
                0.22, down=0.02, forward=0.04, left=0.1, tilt=3, lean=6, right_arm=Arm(12, 150, 0, 20),
                left_arm=Arm(22, 10, 0, 30), right_foot=Foot(forward=0.22, up=0.36, heel=10, stands=False),
            ),
            Key(
                0.4, down=0.04, forward=0.14, left=0.04, tilt=6, lean=10, right_arm=Arm(15, 150, 0, 20),
                left_arm=Arm(25, 10, 0, 30), right_foot=ON_STEP, left_foot=Foot(heel=12),
            ),
            Key(
                0.66, down=-0.18, forward=0.38, left=-0.08, tilt=8, lean=8, right_arm=Arm(25, 10, 0, 30),
                left_arm=Arm(15, 150, 0, 20), right_foot=ON_STEP,
                left_foot=Foot(forward=0.12, up=0.2, heel=45, stands=False),
            ),
            Key(
                0.82, down=-0.24, forward=0.42, left=-0.06, lean=3, right_arm=Arm(15, 40), left_arm=Arm(12, 100),
                right_foot=ON_STEP, left_foot=Foot(forward=0.4, up=0.42, heel=10, stands=False),
            ),
            Key(1, down=0.004 - HIGH, forward=STEP, **feet(ON_STEP)),
        ),
    ),
    "throw": Action(
        2,
        (
            Key(0),
            Key(
                0.32, down=0.04, forward=-0.03, left=-0.1, turn=-30, tilt=-3, lean=-4, twist=-30, bend=5,
                right_arm=Arm(88, 105, -75, 95), left_arm=Arm(70, 15, 20, 25),
                left_foot=Foot(forward=0.15, up=0.14, heel=15, stands=False),
            ),
            Key(
                0.47, down=0.06, forward=0.18, left=-0.02, turn=-15, twist=-25, right_arm=Arm(95, 100, -90, 95),
                left_arm=Arm(75, 25, 20, 20), right_foot=Foot(outward=35), left_foot=Foot(forward=0.45),
            ),
            Key(
                0.57, down=0.07, forward=0.28, left=0.02, turn=15, tilt=5, lean=10, twist=15, bend=-8,
                right_arm=Arm(135, 35, -20, 25), left_arm=Arm(40, 60, 0, 45), right_foot=Foot(heel=28, outward=35),
                left_foot=Foot(forward=0.45),
            ),
            Key(
                0.68, down=0.09, forward=0.34, left=0.04, turn=25, tilt=12, lean=25, twist=28, bend=5,
                right_arm=Arm(55, -25, 30, 20), left_arm=Arm(30, 120, 0, 40), right_foot=Foot(heel=42, outward=35),
                left_foot=Foot(forward=0.45),
            ),
            Key(
                0.84, down=0.04, forward=0.42, left=0.02, turn=5, tilt=3, lean=8, twist=8,
                right_arm=Arm(20, 20, 10, 25), left_arm=Arm(15, 75, 0, 25),
                right_foot=Foot(forward=0.25, up=0.08, heel=20, stands=False), left_foot=Foot(forward=0.45),
            ),
            Key(1, forward=0.45, **feet(Foot(forward=0.45))),
        ),
    ),
    "turn": Action(
        2.2,
        (
            Key(0),
            Key(
                0.18, down=0.02, left=-0.08, turn=25, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                left_foot=Foot(forward=-0.08, up=0.08, left=-0.05, heel=15, outward=45, stands=False),
            ),
            Key(
                0.34, down=0.02, turn=65, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                right_foot=Foot(heel=15, outward=-10), left_foot=HALF_LEFT,
            ),
            Key(
                0.54, down=0.02, left=0.04, turn=115, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                right_foot=Foot(forward=0.14, up=0.1, left=0.2, heel=20, outward=-100, stands=False),
                left_foot=HALF_LEFT,
            ),
            Key(
                0.7, down=0.02, left=-0.02, turn=150, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                right_foot=HALF_RIGHT, left_foot=HALF_LEFT._replace(heel=12),
            ),
            Key(
                0.86, down=0.02, left=0.08, turn=172, lean=2, twist=8, **arms(Arm(14, 60, 10, 25)),
                right_foot=HALF_RIGHT,
                left_foot=Foot(forward=-0.1, up=0.08, left=-0.28, heel=15, outward=150, stands=False),
            ),
            Key(1, turn=180, right_foot=HALF_RIGHT, left_foot=Foot(left=-0.389, outward=187)),
        ),
    ),
    "wave": Action(
        2.8,
        (
            Key(0),
            Key(0.2, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=80)),
            Key(0.31, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=55)),
            Key(0.42, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=110)),
            Key(0.53, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=55)),
            Key(0.64, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=110)),
            Key(0.77, bend=-3, nod=-4, right_arm=WAVE._replace(elbow=65)),
            Key(1),
        ),
    ),
}  # fmt: skip
