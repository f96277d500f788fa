"""Small robots as texts of MJCF and URDF files, and random ones; their models in MuJoCo.

Import it after ``pytest.importorskip("mujoco")``.
"""

import io
import re

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

FREE, BALL, SLIDE, HINGE = range(4)


OLD = tuple(map(int, mujoco.__version__.split(".")[:2])) < (4, 0)


def opened(text):
    """Return a file of this text; skip the test of a URDF file where MuJoCo is too old for it."""
    if OLD and "<robot" in text:
        pytest.skip("MuJoCo 4.0 reads URDF files")
    return io.StringIO(text)


def mjcf(bodies, before="", after=""):
    return f'<mujoco model="robot">{before}<worldbody>{bodies}</worldbody>{after}</mujoco>'


def link(name, parent, kind, *, inside="", origin='<origin xyz="0.1 0.2 0.3" rpy="0.3 -0.2 0.5"/>', joint=""):
    """Return a link of a URDF file, and the joint that carries it."""
    return (
        f'<link name="{name}">{inside}</link><joint name="{joint or name + "_joint"}" type="{kind}">'
        f'<parent link="{parent}"/><child link="{name}"/>{origin}<axis xyz="0 0.6 -0.8"/>'
        '<limit lower="-1" upper="2" effort="1" velocity="1"/></joint>'
    )


def urdf(*links, base="base"):
    return f'<?xml version="1.0"?><!-- a <comment> --><robot name="r"><link name="{base}"/>{"".join(links)}</robot>'


# The text of each robot, and `held`.
ROBOTS = {
    "free root": (
        mjcf(
            '<body name="pelvis" pos="0 0 0.8" quat="1 2 3 4"><freejoint/>'
            '<body name="thigh" pos="0.1 0 -0.2" quat="1 0.1 0.2 0.3"><joint name="hip" axis="0 -3 0"/>'
            '<body name="shank" pos="0 0.1 -0.4"><joint name="knee" axis="1 1 1"/></body></body></body>'
        ),
        {},
    ),
    "points of joints": (
        mjcf(
            '<body name="arm" pos="0.1 0.2 0.3" axisangle="1 2 3 40"><joint name="a" pos="0.1 0 0" axis="1 0 0"/>'
            '<joint name="b" pos="0.1 0 0" axis="0 1 0"/><joint name="c" pos="0 -0.2 0.3" axis="0 1 1"/>'
            '<body name="hand" pos="0.3 0 0"><joint name="d" pos="-0.1 0 0.05"/><body name="tip" pos="0.1 0 0"/>'
            "</body></body>"
        ),
        {},
    ),
    "references, degrees, orders of Euler angles": (
        mjcf(
            '<body name="a" euler="10 20 30"><joint name="j" ref="30" range="-20 40" axis="1 2 0"/>'
            '<body name="b" pos="1 0 0" euler="90 0 -90"><joint name="k" ref="-10" pos="0 0.1 0"/>'
            '<joint name="l" ref="5" pos="0 0.2 0" axis="1 0 0"/></body></body>',
            '<compiler eulerseq="ZYx"/>',
        ),
        {},
    ),
    "ball joints": (
        mjcf(
            '<body name="a" pos="0 0 1" xyaxes="0 1 0 -1 0 1"><joint name="s" type="ball"/>'
            '<body name="b" pos="1 0 0"><joint name="t" type="ball" pos="0.1 0.2 0.3"/>'
            '<body name="c" zaxis="1 1 1" pos="0 1 0"><joint name="h" axis="0 1 0"/><body name="d" pos="0 0 1"/>'
            "</body></body></body>"
        ),
        {},
    ),
    "classes": (
        mjcf(
            '<body name="a" childclass="v"><joint name="i"/><body name="b" pos="0 0 1" childclass="w">'
            '<joint name="k"/><joint name="l" class="v"/><body name="c" pos="1 0 0"/></body></body>',
            '<default><joint pos="0.1 0 0"/><default class="v"><joint axis="1 0 0" range="-10 10"/>'
            '<default class="w"><joint axis="0 2 0"/></default></default></default>',
        ),
        {},
    ),
    "frames and copies": (
        mjcf(
            '<frame euler="10 20 30" pos="1 2 3"><body name="a" euler="10 0 90"><joint name="j"/>'
            '<replicate count="3" euler="0 0 90" offset="0 0.1 0"><frame pos="0 0 0.1" quat="1 1 0 0">'
            '<body name="f" pos="1 0 0"><joint name="q" axis="0 1 0"/><body name="g" pos="0 1 0"/></body></frame>'
            "</replicate></body></frame>"
        ),
        {},
    ),
    "held": (
        mjcf(
            '<body name="base"><joint name="x" type="slide" axis="1 0 0" ref="0.1"/>'
            '<joint name="y" type="slide" axis="0 2 1"/><joint name="yaw" ref="10"/>'
            '<body name="arm" pos="0 0 1"><joint name="s" type="ball" pos="0.1 0 0"/>'
            '<body name="hand" pos="1 0 0"><joint name="w" axis="0 1 0" pos="0 0 0.2" range="-90 90" ref="20"/>'
            '<joint name="v" axis="1 0 0"/>'
            '<body name="finger" pos="0 0 0.1"><joint name="grip" type="slide" pos="1 1 1"/>'
            '<joint name="bend" axis="1 1 0" pos="0 1 0"/></body></body></body></body>'
        ),
        {"x": 0.7, "y": -0.2, "w": 0.4, "s": [0.1, 0.5, -0.7], "grip": 0.03},
    ),
    "slides": (
        mjcf(
            '<body name="base"><joint name="x" type="slide" axis="1 0 0" ref="0.1"/>'
            '<joint name="y" type="slide" axis="0 2 1"/><joint name="yaw" ref="10"/>'
            '<body name="lift" pos="0 0 1" quat="1 1 0 0"><joint name="lift" type="slide" pos="1 1 1" ref="-0.3"/>'
            '<body name="arm" pos="0 0 1"><joint name="s" type="ball" pos="0.1 0 0"/>'
            '<body name="finger" pos="0 0 0.1"><joint name="grip" type="slide" pos="1 1 1" range="0 0.04"/>'
            '<joint name="bend" axis="1 1 0" pos="0 1 0"/></body></body></body></body>'
        ),
        {},
    ),
    "URDF": (
        urdf(
            link("thigh", "base", "revolute"),
            link("shank", "thigh", "continuous"),
            link("sole", "shank", "fixed", origin='<origin xyz="0 0 -0.1" rpy="0 1.5707963 0"/>'),
            link("toe", "sole", "revolute"),
            link("arm", "base", "revolute", origin=""),
        ),
        {},
    ),
    "URDF that floats": (
        urdf(link("base", "world", "floating"), link("arm", "base", "revolute"), base="world"),
        {},
    ),
    "URDF on a plane": (
        urdf(link("arm", "base", "planar"), link("hand", "arm", "prismatic"), link("finger", "hand", "continuous")),
        {"arm_joint_TX": 0.3, "arm_joint_TY": -2.0},
    ),
}


def random_robot(seed):
    """Return the text of a robot of random bodies and joints, and the joints that are held."""
    rng = np.random.default_rng(seed)
    texts, held, parents = [], {}, []
    for i in range(9):
        joints, kind = "", rng.integers(5)
        kinds = [[], ["hinge"], ["hinge"] * 3, ["ball"], ["slide", "hinge", "slide"]][kind]
        for k, of in enumerate(kinds):
            name = f"j{i}{k}"
            pos = rng.normal(size=3) * rng.integers(2)
            ref = float(rng.normal() * rng.integers(2)) if of != "ball" else 0.0
            joints += f'<joint name="{name}" type="{of}" pos="{numbers(pos)}" axis="{numbers(rng.normal(size=3))}"'
            joints += f' ref="{ref!r}"/>' if ref else "/>"
            if rng.random() < 0.2 and i:
                held[name] = rng.normal(size=3) if of == "ball" else float(rng.normal())
        place = f'pos="{numbers(rng.normal(size=3))}"' + f' quat="{numbers(rng.normal(size=4))}"' * rng.integers(2)
        texts.append(f'<body name="b{i}" {place}>{joints}{{{i}}}</body>')
        parents.append(int(rng.integers(-1, i)))
    texts.append('<body name="last" pos="1 0 0"><joint name="last"/></body>')
    parents.append(0)
    inside = dict.fromkeys(range(-1, 10), "")
    for i in reversed(range(10)):
        inside[parents[i]] = texts[i].replace(f"{{{i}}}", inside[i]) + inside[parents[i]]
    return mjcf(inside[-1], '<compiler angle="radian"/>'), held


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


ROBOTS |= {f"random {seed}": random_robot(seed) for seed in range(3)}


def compiled(text):
    """Compile a robot with all its bodies, without geometry, each with a mass."""
    spec = mujoco.MjSpec.from_string(re.sub(r"<geom[^>]*/>", "", text))
    spec.compiler.fusestatic = False
    for body in spec.bodies[1:]:
        body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
    return spec.compile()


def random_qpos(model, held, rng):
    """Return random numbers of all joints, with unit quaternions."""
    qpos = rng.normal(size=model.nq)
    for i in range(model.njnt):
        at, name = model.jnt_qposadr[i], model.joint(i).name
        if model.jnt_type[i] in (FREE, BALL):
            at += 3 * (model.jnt_type[i] == FREE)
            qpos[at : at + 4] /= np.linalg.norm(qpos[at : at + 4])
        if name in held:
            ball = model.jnt_type[i] == BALL
            value = Rotation.from_rotvec(held[name]).as_quat()[[3, 0, 1, 2]] if ball else held[name]
            qpos[at : at + (4 if ball else 1)] = value
    return qpos


def root_of(model, skeleton):
    """Return the last body that is not a joint of the skeleton: the root."""
    return max(b for b in range(model.nbody) if model.body(b).name not in skeleton.joint_names)


SCENE = mjcf(
    '<body name="table" pos="1 0 0"><body name="drawer"><joint name="pull" type="slide"/></body></body>'
    '<body name="pelvis"><freejoint name="floating"/><body name="torso" pos="0 0 1"><joint name="waist"/>'
    '<body name="arm" pos="0 1 0"><joint name="shoulder" axis="1 0 0"/></body></body>'
    '<body name="leg" pos="0 0 -1"><joint name="hip" axis="1 0 0"/></body></body>'
    '<body name="target" mocap="true" pos="0 0 1"/>'
)
TWO_FREE = mjcf(
    '<body name="a"><freejoint/><body name="arm" pos="1 0 0"><joint name="i"/></body></body>'
    '<body name="b"><freejoint name="floats"/><body name="leg" pos="1 0 0"><joint name="j"/></body></body>'
)
