"""
Joint angles over the stride
============================

`joint_angles` measures a walk as those who measure people do it, `gait_events` finds its strides, and
`JointAnglesDisplay` draws the curves of both sides. Other movements have repetitions: squats, and how far the most
unusual one is from the others, with `RepetitionsDisplay`. If SKPOSE_CMU names a folder of the CMU database, the walk of
one of its people is the last part.
"""

import os
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from skpose import Motion, forward_kinematics
from skpose.biomechanics import gait_events, joint_angles
from skpose.datasets import humanoid, load_cmu, make_gait
from skpose.motions import segment_repetitions
from skpose.plot import JointAnglesDisplay, RepetitionsDisplay

# %%
# A generated walk of eight seconds. Generated people walk on the spot: here the lower foot stands still, which moves
# the root.
walk = make_gait(1, 1, activities=["walk"], duration=8, random_state=0)[0]
feet = [walk.skeleton.joint_names.index(name) for name in ("left_foot", "right_foot")]
balls = forward_kinematics(walk.angles, walk.skeleton)[:, feet]
lower = balls[:-1, :, 1].argmin(axis=1)
steps = -np.diff(balls, axis=0)[np.arange(len(lower)), lower]
walk = replace(walk, root_positions=np.concatenate([np.zeros((1, 3)), steps.cumsum(axis=0)]))
angles, events = joint_angles(walk), gait_events(walk)
print(angles)
print(events)

# %%
# Each side has its own strides, from the contact of its foot (0 %) to the next one (100 %).
JointAnglesDisplay.from_angles(angles, events)
plt.show()

# %%
# Other angles, by the names of their columns without the side; one column fits into a narrow page. Each stride is a
# thin line here.
JointAnglesDisplay.from_angles(
    angles, events, names=["hip_adduction", "shoulder_flexion"], n_columns=1, show_cycles=True
)
plt.show()

# %%
# Without cycles they are curves over time.
JointAnglesDisplay.from_angles(angles, names=["knee_flexion", "elbow_flexion"], n_columns=2)
plt.show()

# %%
# Eight squats that differ a little in depth, tempo and posture. At the bottom of the sixth (5) the left knee goes
# inward by 15°.
rng = np.random.default_rng(0)
person = humanoid()
deep = np.zeros(person.n_dofs)
for name, angle in {"thigh_rx": -1.6, "shank_rx": 2.0, "foot_rx": -0.5, "upper_arm_rx": -1.3}.items():
    for side in ("left", "right"):
        deep[person.dof_names.index(f"{side}_{name}")] = angle
squats = []
for number in range(8):
    phase = np.linspace(0.0, 1.0, rng.integers(90, 120))
    depth = np.sin(np.pi * phase) ** 2 * rng.normal(1.0, 0.03)
    squat = depth[:, None] * (deep + rng.normal(0.0, 0.02, size=deep.shape))
    if number == 5:
        inward = np.clip(1.0 - np.abs(phase - 0.5) / 0.15, 0.0, 1.0)
        squat[:, person.dof_names.index("left_thigh_ry")] -= np.radians(15.0) * inward
    squats += [squat, np.zeros((20, person.n_dofs))]
recording = Motion(person, np.concatenate(squats), frame_rate=50.0)

# %%
# `segment_repetitions` finds them. Both sides of the angles have the same repetitions; the band of the left hip's
# adduction is wide where one of the squats is not like the others.
found = segment_repetitions(recording, random_state=0)
print(found)
JointAnglesDisplay.from_angles(joint_angles(recording), found, names=["hip_flexion", "knee_flexion", "hip_adduction"])
plt.show()

# %%
# Which one was wrong, where and when: in colour the squat with the most unusual joint, in grey where the others have
# it. It is the first row of `Repetitions.to_pandas`, sorted by `unusual`.
display = RepetitionsDisplay.from_repetitions(found)
print(f"repetition {display.repetition_}: {display.joint_}, {100 * display.deviation_:.1f} cm off")
plt.show()

# %%
# Another one, in the same colours.
RepetitionsDisplay.from_repetitions(found, repetition=2)
plt.show()

# %%
# A recorded walk.
folder = os.environ.get("SKPOSE_CMU")
if folder:
    dataset = load_cmu(folder)
    recorded = dataset[(dataset.subjects == "35") & (dataset.actions == "walk")][0]
    JointAnglesDisplay.from_angles(joint_angles(recorded), gait_events(recorded))
    plt.show()
