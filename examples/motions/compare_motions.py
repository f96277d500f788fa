"""
Two motions compared joint by joint
===================================

Which joint is off, when, and by how much? `align_motions` finds the frames of two motions that belong together, and the
differences of all joints there: the distances of their positions, and the angles between their rotations. If
SKPOSE_HDM05 names a folder of files of the database HDM05, the example also compares squats.
"""

# sphinx_gallery_tile = (1, 1)

import os

import matplotlib.pyplot as plt
import numpy as np

from skpose import Motion, motion_distances
from skpose.datasets import load_hdm05, make_gait
from skpose.motions import align_motions
from skpose.plot import AlignmentDisplay
from skpose.view import player

# %%
# A walk, and the same walk at another tempo, first slower, then faster. From 1.0 to 1.3 s of the first one the left
# knee bends 30° too far.
walk = make_gait(1, 1, activities=["walk"], duration=2.0, random_state=0)[0]
slow, fast = np.linspace(0, 0.7, 60, endpoint=False), np.linspace(0.7, walk.times[-1], 50)
times = np.concatenate([slow, fast])
angles = np.stack([np.interp(times, walk.times, column) for column in walk.angles.T], axis=1)
bend = np.radians(30) * np.clip(np.minimum(times - 0.95, 1.35 - times) / 0.05, 0, 1)
angles[:, walk.skeleton.dof_names.index("left_shank_rx")] += bend
other = Motion(walk.skeleton, angles, walk.frame_rate)

# %%
# The distances of the positions are largest where the bent knee moves the leg, at the ankle and the foot.
alignment = align_motions(walk, other)
print(alignment)
AlignmentDisplay.from_alignment(alignment, projection="zy")
plt.show()

# %%
# Both in the player, in step: colours show how far each joint is from its counterpart. A notebook shows the page; in a
# script, `player(...).open()` shows it in the browser.
player([walk, other], labels=["walk", "other tempo, bent knee"], alignment=alignment)

# %%
# The rotations show the joint itself, the knee.
AlignmentDisplay.from_alignment(alignment, quantity="rotation", projection="zy")
plt.show()

# %%
# The same as numbers, the largest first.
for off in alignment.joint_differences("rotation")[:3]:
    print(f"{off.place:<28} {np.degrees(off.largest):5.1f}° at {off.frame_a / alignment.frame_rate:.2f} s")

# %%
# Which of the 12 squats of one person in HDM05 is wrong? Each is compared with the most typical one, whose distances to
# all others have the least sum. In three the right knee, the end of "rfemur", is more than 50 cm off at the lowest
# point: a fault of these recordings, which have it behind the hip. The distances of whole motions do not show it.
folder = os.environ.get("SKPOSE_HDM05")
if folder:
    dataset = load_hdm05(folder)
    squats = dataset[(dataset.actions == "squat") & (dataset.subjects == "bd")]
    motions = [motion.resample(30) for motion in squats]
    distances = motion_distances(motions)
    typical = motions[distances.sum(axis=1).argmin()]
    alignments = [align_motions(typical, motion) for motion in motions]
    for alignment in alignments:
        print(alignment)
    largest = [alignment.joint_differences()[0].largest for alignment in alignments]
    AlignmentDisplay.from_alignment(alignments[int(np.argmax(largest))], projection="zy")
    plt.show()
