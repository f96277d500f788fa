"""A performance of an action: the motion of one person, once, from key poses and from how the person departs from them.

Key poses state where the pelvis and the feet are. The legs follow (`_legs.py`), and depart from that as the other
joints do. That moves the feet, and those that stand are then put back: on the ground, near the place that is planned,
and there they stay. The pelvis is above them as planned, as high as the knees are bent. Between the key poses
everything moves along monotone cubic curves (PCHIP), and legs that stand are solved once more, for every frame, so that
their feet do not slide.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation

from skpose.datasets._key_poses import Action, Arm, Foot, Key
from skpose.datasets._legs import STRAIGHT, Leg, LegAngles, place_foot, solve_leg
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import continuous_columns

SIDES = {"left": 1.0, "right": -1.0}
RHYTHM, RISES = 0.25, 60.0  # of the clavicle: how far it rises with the upper arm, and from where, degrees
# Limits of what a person can do, degrees: flexion of elbow and knee; the upper arm about itself, inward; ankle and
# wrist, about x and z.
ELBOW, KNEE, INWARD = (0.0, 150.0), (6.0, 130.0), (-100.0, 100.0)
ANKLE, WRIST = ((-40.0, -35.0), (60.0, 35.0)), ((-75.0, -45.0), (75.0, 45.0))
NECK = 45.0  # of neck and head each, from how they are planned
CLEARANCE = 0.03  # of feet that swing, above the floor, m
YAW = (-6.0, 6.0)  # of feet that stand, from the planned direction
# Feet that stand, from where they are planned: outward, up and forward, as shares of the distance of a hip.
PLACED = ((-0.4, -1.0, -0.5), (0.6, 1.0, 0.5))


class Track(NamedTuple):
    """A foot over time."""

    ball: np.ndarray  # (n, 3), m
    rotation: Rotation  # (n,), in the world
    contact: np.ndarray  # (n,) the number of the place where it stands, −1 where it does not


class Stance(NamedTuple):
    """Pelvis and feet over time."""

    position: np.ndarray  # (n, 3), of the pelvis, m
    turned: np.ndarray  # (n, 2), the turn of the pelvis about y and its tilt about its own x, rad
    feet: dict[str, Track]

    @property
    def pelvis(self) -> Rotation:
        """The orientation of the pelvis in the world."""
        return Rotation.from_euler("YX", self.turned)


def perform(
    skeleton: Skeleton, action: Action, departures: np.ndarray, duration: float, late: float, frame_rate: float
) -> Motion:
    """Return a motion of the humanoid.

    `departures` (n_keys, n_dofs) are rotations about the own axes of the joints, rad; `late` is the share of the
    duration by which the middle of the action is late.
    """
    keys, legs = action.keys, {side: Leg.of(skeleton, side) for side in SIDES}
    column = {name: k for k, name in enumerate(skeleton.dof_names)}
    own = {b.name: departures[:, [column[f"{b.name}_r{axis}"] for axis in b.dofs]] for b in skeleton.bones if b.dofs}
    departed = _depart(keys, legs, own)
    stance = _stand(keys, legs, departed)
    joints = _upper_joints(keys, own) | _leg_joints(legs, stance, departed, own)

    share = np.array([key.time for key in keys])
    at = duration * (share + late * 4.0 * share * (1.0 - share))
    times = np.arange(int(duration * frame_rate) + 1) / frame_rate

    def between(values: np.ndarray) -> np.ndarray:
        return PchipInterpolator(at, values)(np.minimum(times, at[-1]))

    def rotate_between(rotations: Rotation) -> Rotation:
        middle = rotations.mean()
        return middle * Rotation.from_rotvec(between((middle.inv() * rotations).as_rotvec()))

    before = np.clip(np.searchsorted(at, times, side="right") - 1, 0, len(at) - 2)
    feet = {}
    for side, foot in stance.feet.items():
        contact = np.where(foot.contact[1:] == foot.contact[:-1], foot.contact[1:], -1)[before]
        feet[side] = Track(between(foot.ball), rotate_between(foot.rotation), contact)
    stance = _within_reach(Stance(between(stance.position), between(stance.turned), feet), legs)

    moving = {
        name: rotate_between(values) if isinstance(values, Rotation) else between(values)
        for name, values in joints.items()
    }
    for side, foot in stance.feet.items():
        solved = _joints_of(side, solve_leg(legs[side], stance.position, stance.pelvis, foot.ball, foot.rotation))
        solved[f"{side}_toes"] = -_heel(foot.rotation)[:, None]  # they stay on the ground
        for name, values in solved.items():
            moving[name] = _choose(foot.contact >= 0, values, moving[name])
    columns = [
        continuous_columns(bone, joint) if isinstance(joint := moving[bone.name], Rotation) else joint
        for bone in skeleton.bones
        if bone.dofs
    ]
    return Motion(skeleton, np.concatenate(columns, axis=1), frame_rate, stance.position, stance.turned, "YX")


def _heel(rotation: Rotation) -> np.ndarray:
    """Return the rotation of feet about their balls, heel up, rad."""
    return np.arcsin(np.clip(-rotation.apply([0.0, 0.0, 1.0])[:, 1], -1.0, 1.0))


def _upper_joints(keys: Sequence[Key], own: dict[str, np.ndarray]) -> dict[str, Rotation | np.ndarray]:
    """Return the joints of trunk and arms: the rotations (n_keys,), or the angles (n_keys, n_dofs), rad."""
    trunk = np.array([(key.lean, key.twist, key.bend) for key in keys])
    nod = np.array([(key.nod, 0.0, 0.0) for key in keys])
    joints: dict[str, Rotation | np.ndarray] = {}
    for name, whole in (("abdomen", trunk), ("chest", trunk), ("neck", nod), ("head", nod)):
        turn = own[name]
        if whole is nod:
            size = np.linalg.norm(turn, axis=1, keepdims=True)
            turn = turn * np.minimum(1.0, np.radians(NECK) / np.maximum(size, 1e-12))
        joints[name] = Rotation.from_euler("xyz", whole / 2.0, degrees=True) * Rotation.from_rotvec(turn)
    for side, sign in SIDES.items():
        arms = [getattr(key, f"{side}_arm") for key in keys]
        joints[f"{side}_upper_arm"] = _upper_arm(arms, sign, own[f"{side}_upper_arm"])
        rises = np.array([max(0.0, arm.raised - RISES) * RHYTHM for arm in arms])
        joints[f"{side}_clavicle"] = np.radians(np.outer(rises, [0.0, sign])) + own[f"{side}_clavicle"]
        elbows = np.array([[arm.elbow] for arm in arms]) - np.degrees(own[f"{side}_forearm"])
        joints[f"{side}_forearm"] = -np.radians(np.clip(elbows, *ELBOW))
        joints[f"{side}_hand"] = np.clip(own[f"{side}_hand"], *np.radians(WRIST))
    return joints


def _upper_arm(arms: Sequence[Arm], sign: float, own: np.ndarray) -> Rotation:
    """Return the rotations of an upper arm: about itself, within what a person can do, and then to where it points."""
    plane, raised, inward = np.radians([(arm.plane, arm.raised, arm.inward) for arm in arms]).T
    axis = np.stack([-np.cos(plane), np.zeros(len(arms)), sign * np.sin(plane)], axis=1)
    swing = Rotation.from_rotvec(raised[:, None] * axis)
    rotations = swing * Rotation.from_rotvec(np.outer(-sign * inward, [0.0, 1.0, 0.0])) * Rotation.from_rotvec(own)
    # A rotation is one about y, after which the least one brings the arm to its direction.
    quaternions = rotations.as_quat()
    about = np.angle(np.exp(2j * np.arctan2(quaternions[:, 1], quaternions[:, 3])))
    low, high = np.sort(-sign * np.radians(INWARD))
    excess = np.clip(about, low, high) - about
    return rotations * Rotation.from_rotvec(np.outer(excess, [0.0, 1.0, 0.0]))


def _plan_stance(keys: Sequence[Key], legs: dict[str, Leg]) -> Stance:
    """Return pelvis and feet at the key poses as these state them."""
    length, ankle = legs["left"].length, -float(legs["left"].foot[1])
    return Stance(
        np.array([(length * k.left, ankle + length * (1.0 - k.down), length * k.forward) for k in keys]),
        np.radians([(k.turn, k.tilt) for k in keys]),
        {side: _plan([getattr(key, f"{side}_foot") for key in keys], legs[side], sign) for side, sign in SIDES.items()},
    )


def _depart(keys: Sequence[Key], legs: dict[str, Leg], own: dict[str, np.ndarray]) -> dict[str, LegAngles]:
    """Return the legs at the key poses that depart from what is planned, with the feet where that brings them."""
    plan, departed = _plan_stance(keys, legs), {}
    for side, foot in plan.feet.items():
        angles = solve_leg(legs[side], plan.position, plan.pelvis, foot.ball, foot.rotation)
        departed[side] = LegAngles(
            angles.hip * Rotation.from_rotvec(own[f"{side}_thigh"]),
            np.clip(angles.knee + own[f"{side}_shank"][:, 0], *np.radians(KNEE)),
            np.clip(angles.ankle + own[f"{side}_foot"], *np.radians(ANKLE)),
        )
    return departed


def _stand(keys: Sequence[Key], legs: dict[str, Leg], departed: dict[str, LegAngles]) -> Stance:
    """Return pelvis and feet at the key poses, with those feet on the ground that stand."""
    plan = _plan_stance(keys, legs)
    pelvis, position = plan.pelvis, plan.position.copy()
    balls: dict[str, np.ndarray] = {}
    yaw, rotations = {}, {}

    def height(side: str, k: int) -> float:
        """Return the height of the pelvis at which a knee is bent as it departs, above a foot that stands."""
        leg, foot = legs[side], plan.feet[side].rotation[k]
        hip = pelvis[k].apply(leg.hip)
        ankle = balls[side][k] - foot.apply(leg.foot)
        away = ankle - position[k] - hip
        squared = leg.thigh**2 + leg.shank**2 + 2.0 * leg.thigh * leg.shank * np.cos(departed[side].knee[k])
        return ankle[1] - hip[1] + np.sqrt(max(squared - away[0] ** 2 - away[2] ** 2, 0.0))

    for side in SIDES:
        ball, rotation = place_foot(legs[side], departed[side])
        balls[side], rotations[side] = pelvis.apply(ball), pelvis * rotation  # the ball, from the pelvis
        ahead, planned = (of.apply([0.0, 0.0, 1.0]) for of in (rotations[side], plan.feet[side].rotation))
        turned = np.arctan2(ahead[:, 0], ahead[:, 2]) - np.arctan2(planned[:, 0], planned[:, 2])
        yaw[side] = np.clip(np.angle(np.exp(1j * turned)), *np.radians(YAW))
    shift = np.zeros(3)
    for k, key in enumerate(keys):
        contact = {side: plan.feet[side].contact[k] for side in SIDES}
        stands = [side for side in SIDES if contact[side] >= 0]
        position[k] += shift
        for side in stands:
            ball = balls[side]
            if k and contact[side] == plan.feet[side].contact[k - 1]:
                ball[k], yaw[side][k] = ball[k - 1], yaw[side][k - 1]
            else:
                ball[k] = position[k] + _near(ball[k], plan, side, k, abs(float(legs[side].hip[0])))
                ball[k, 1] = plan.feet[side].ball[k, 1]
        if stands:  # people keep their balance: the pelvis is where it is planned to be from the feet
            step = np.mean([balls[side][k] - plan.feet[side].ball[k] for side in stands], axis=0) - shift
            step[1] = 0.0
            shift += step
            position[k] += step
            if not key.sits:
                position[k, 1] = np.mean([height(side, k) for side in stands])
        elif k:
            position[k, 1] += position[k - 1, 1] - plan.position[k - 1, 1]
    feet = {}
    for side, foot in plan.feet.items():
        stood = foot.contact >= 0
        planned = Rotation.from_rotvec(np.outer(yaw[side], [0.0, 1.0, 0.0])) * foot.rotation
        ball = _choose(stood, balls[side], position + balls[side])
        feet[side] = Track(ball, _choose(stood, planned, rotations[side]), foot.contact)
    return _within_reach(Stance(position, plan.turned, feet), legs)


def _leg_joints(
    legs: dict[str, Leg], stance: Stance, departed: dict[str, LegAngles], own: dict[str, np.ndarray]
) -> dict[str, Rotation | np.ndarray]:
    """Return the joints of the legs at the key poses: solved where the foot stands."""
    joints: dict[str, Rotation | np.ndarray] = {}
    for side, foot in stance.feet.items():
        stands, low = foot.contact >= 0, foot.ball[:, 1] < CLEARANCE
        ball = np.where((low & ~stands)[:, None], foot.ball * [1.0, 0.0, 1.0] + [0.0, CLEARANCE, 0.0], foot.ball)
        solved = _joints_of(side, solve_leg(legs[side], stance.position, stance.pelvis, ball, foot.rotation))
        for name, values in _joints_of(side, departed[side]).items():
            joints[name] = _choose(stands | low, solved[name], values)
        joints[f"{side}_toes"] = _choose(stands, -_heel(foot.rotation)[:, None], own[f"{side}_toes"])
    return joints


def _joints_of(side: str, angles: LegAngles) -> dict[str, Rotation | np.ndarray]:
    """Return the joints of a leg by their names, without the toes."""
    return {f"{side}_thigh": angles.hip, f"{side}_shank": angles.knee[:, None], f"{side}_foot": angles.ankle}


def _choose(first: np.ndarray, values: Rotation | np.ndarray, others: Rotation | np.ndarray) -> Rotation | np.ndarray:
    """Return values (n,) or (n, k) where `first`, others elsewhere."""
    if isinstance(values, Rotation) and isinstance(others, Rotation):
        return Rotation.from_quat(np.where(first[:, None], values.as_quat(), others.as_quat()))
    return np.where(first[:, None], values, others)


def _plan(feet: Sequence[Foot], leg: Leg, sign: float) -> Track:
    """Return a foot at the key poses as planned."""
    from_hip = leg.length * np.array([(foot.left, foot.up, foot.forward) for foot in feet])
    yaw, heel = np.radians([(sign * foot.outward, foot.heel) for foot in feet]).T
    flat = Rotation.from_rotvec(np.outer(yaw, [0.0, 1.0, 0.0]))
    ball = leg.hip + from_hip + flat.apply(leg.foot * [1.0, 0.0, 1.0])
    places = [(foot.forward, foot.up, foot.left, foot.outward) if foot.stands else None for foot in feet]
    numbers = np.cumsum([0, *(a != b for a, b in pairwise(places))])
    contact = np.array([number if foot.stands else -1 for number, foot in zip(numbers, feet, strict=True)])
    return Track(ball, flat * Rotation.from_rotvec(np.outer(heel, [1.0, 0.0, 0.0])), contact)


def _near(from_pelvis: np.ndarray, stance: Stance, side: str, k: int, hip: float) -> np.ndarray:
    """Return where a foot begins to stand, from the pelvis: near where it is planned, and so not in the other's way."""
    turn = Rotation.from_rotvec([0.0, stance.turned[k, 0], 0.0])
    planned = stance.feet[side].ball[k] - stance.position[k]
    away = turn.inv().apply(from_pelvis - planned) * [SIDES[side], 1.0, 1.0] / hip
    return planned + turn.apply(hip * np.clip(away, *PLACED) * [SIDES[side], 1.0, 1.0])


def _within_reach(stance: Stance, legs: dict[str, Leg]) -> Stance:
    """Return it with the pelvis as low and as high as feet that stand let it be: no leg too long, no knee too bent."""
    move = np.zeros(len(stance.position))
    for side, foot in stance.feet.items():
        leg, stands = legs[side], foot.contact >= 0
        away = foot.ball - foot.rotation.apply(leg.foot) - stance.position - stance.pelvis.apply(leg.hip)
        across = away[:, 0] ** 2 + away[:, 2] ** 2
        shortest = leg.thigh**2 + leg.shank**2 + 2.0 * leg.thigh * leg.shank * np.cos(np.radians(KNEE[1]))
        least = np.sqrt(np.maximum(shortest - across, 0.0))
        most = np.sqrt(np.maximum((STRAIGHT * leg.length) ** 2 - across, 0.0))
        move = np.where(stands, np.maximum(move, least + away[:, 1]), move)
        move = np.where(stands, np.minimum(move, most + away[:, 1]), move)
    return stance._replace(position=stance.position + np.outer(move, [0.0, 1.0, 0.0]))
