"""
Do two people walk differently?
===============================

Distances between poses always differ a little: from step to step, from recording to recording. `two_sample_test` asks
whether two *sets* of poses differ by more than that. It compares the sets as they are with all others into which the
same recordings can be split. Recordings are permuted whole, as frames of one recording are not independent.
"""

import matplotlib.pyplot as plt
import numpy as np

from skpose.datasets import make_gait
from skpose.statistics import two_sample_test

gait = make_gait(n_subjects=8, n_sequences=8, activities=["walk"], frame_rate=12, random_state=0)
skeleton = gait.skeleton
print(gait)

# %%
# Walks of two people, eight recordings of each; and one person's recordings, every other one against the rest. The
# energy statistic is zero for equal sets. Sets are never exactly equal, so it means something only next to its values
# for other splits.
one, other = (gait[gait.subjects == subject] for subject in ("01", "02"))
tests = {
    "two people": two_sample_test(one, other, random_state=0),
    "one person, every other recording": two_sample_test(one[::2], one[1::2], random_state=0),
}
for name, test in tests.items():
    print(f"{name}: {test}")


# %%
# The null distribution is that of the statistic where the labels mean nothing. Sets of equal size keep their statistic
# when they are exchanged: of 70 splits of eight recordings two have each value, so that p is at least 2/70.
def show(ax, test, title):
    bins = np.linspace(0, 1.05 * max(test.statistic, test.null_distribution.max()), 40)
    ax.hist(test.null_distribution, bins, color="0.75", label="permutations")
    ax.axvline(test.statistic, color="#d55e00", label="as given")
    ax.set(title=f"{title}\np = {test.pvalue:.3f}", xlabel="energy statistic (m)", ylabel="splits")


figure, axes = plt.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
for ax, (name, test) in zip(axes, tests.items(), strict=True):
    show(ax, test, name)
axes[0].legend()
plt.show()

# %%
# Before and after: one walk of each of eight people, and a later one in which they bend the trunk by 5° more. People
# differ from one another by more than that. Who is compared with whom matters: ``paired=True`` exchanges only the two
# walks of one person, and the differences between people cancel.
before, after = (np.stack([motion.angles for motion in gait[gait.trials == trial]]) for trial in ("01", "02"))
after[..., skeleton.dof_names.index("abdomen_rotvec_x")] += np.radians(5)
tests = {
    "eight people against eight": two_sample_test(before, after, skeleton=skeleton, random_state=0),
    "eight pairs": two_sample_test(before, after, skeleton=skeleton, paired=True),
    "eight pairs, MMD": two_sample_test(before, after, skeleton=skeleton, paired=True, statistic="mmd"),
}
for name, test in tests.items():
    print(f"{name}: {test}")

figure, axes = plt.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
for ax, name in zip(axes, ["eight people against eight", "eight pairs"], strict=True):
    show(ax, tests[name], name)
axes[0].legend()
plt.show()
