"""
Joint angles over the stride
============================

`joint_angles` measures the joint angles of a walk, `gait_events` finds its strides, and `JointAnglesDisplay` draws the
curves of both sides, and those of other people as a band. If SKPOSE_CMU names a folder of the CMU database, the last
part shows a recorded walk.
"""

import os
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from skpose import forward_kinematics
from skpose.biomechanics import gait_events, joint_angles
from skpose.datasets import load_cmu, make_gait
from skpose.plot import JointAnglesDisplay

# %%
# Generated walks of eight seconds. Generated people walk on the spot; here the lower ankle stands still, which moves
# the root.


def walking(motion):
    ends = [motion.skeleton.joint_names.index(name) for name in ("left_shank", "right_shank")]
    ankles = forward_kinematics(motion.angles, motion.skeleton)[:, ends]
    lower = ankles[:-1, :, 1].argmin(axis=1)
    steps = -np.diff(ankles, axis=0)[np.arange(len(lower)), lower]
    return replace(motion, root_positions=np.concatenate([np.zeros((1, 3)), steps.cumsum(axis=0)]))


walk, *others = map(walking, make_gait(6, 1, activities=["walk"], duration=8, random_state=0))
angles, events = joint_angles(walk), gait_events(walk)
print(angles)
print(events)

# %%
# Each side has its own strides, from the contact of its foot (0 %) to the next one (100 %).
JointAnglesDisplay.from_angles(angles, events)
plt.show()

# %%
# Five other people as a band. The norm is a table; a published one with these columns is drawn in the same way.
table = joint_angles(others)
norm = table.groupby(["angle", "phase [%]"])["value [deg]"].agg(["mean", "std"]).reset_index()
JointAnglesDisplay.from_angles(angles, events, norm=norm)
plt.show()

# %%
# Other angles, by the names of their columns without the side, with each stride as a thin line.
JointAnglesDisplay.from_angles(
    angles, events, names=["hip_adduction", "shoulder_flexion"], n_columns=1, show_cycles=True
)
plt.show()

# %%
# A recorded walk.
folder = os.environ.get("SKPOSE_CMU")
if folder:
    dataset = load_cmu(folder)
    recorded = dataset[(dataset.subjects == "35") & (dataset.actions == "walk")][0]
    JointAnglesDisplay.from_angles(joint_angles(recorded), gait_events(recorded))
    plt.show()
