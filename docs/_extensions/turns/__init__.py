"""A person who turns by one angle at the shoulder and at the wrist, to drag."""

from pathlib import Path

import numpy as np

from skpose import forward_kinematics
from skpose.datasets import humanoid
from skpose.view._page import page_of
from skpose.view._skeleton import NUMBERS, skeleton_data

HERE = Path(__file__).parent
SCRIPTS = ("page.js", *NUMBERS, "figure.js", "shape.js")
TURNS = {"shoulder": "left_upper_arm_rz", "wrist": "left_hand_rz"}  # and the columns that turn
SOLE = 0.02  # m below the lowest joint
MOST = np.radians(90)


def page():
    """Return the page."""
    skeleton = humanoid()
    poses = np.zeros((3, skeleton.n_dofs))
    poses[:, skeleton.dof_names.index(TURNS["shoulder"])] = np.linspace(0, MOST, 3)
    height = SOLE - forward_kinematics(poses[:1], skeleton)[..., 1].min()
    around = forward_kinematics(poses, skeleton).reshape(-1, 3)
    around[:, 1] += height
    low, high = around.min(axis=0), around.max(axis=0)
    data = {
        "skeleton": skeleton_data(skeleton),
        "turns": {
            key: {
                "name": f"at the {key}",
                "column": skeleton.dof_names.index(name),
                "hand": skeleton.joint_names.index("left_hand"),
            }
            for key, name in TURNS.items()
        },
        "height": height,
        "size": float((high - low).max()),
        "middle": (0.5 * (low + high)).tolist(),
        "around": [low.tolist(), high.tolist()],
    }
    assets = ("page.css", HERE / "turns.css", *SCRIPTS, HERE / "turns.js")
    return page_of("One angle, two distances", "a person who turns", data, HERE / "turns.html", assets)
