"""Proportions of an adult: lengths as fractions of the height.

After R. Drillis, R. Contini, M. Bluestein, "Body segment parameters: a survey of measurement techniques", Artificial
Limbs 8, 1964.
"""

MEAN_HEIGHT = 1.72  # m

PROPORTIONS = {
    "abdomen": 0.115,  # from the height of the hips up
    "chest": 0.173,  # to the height of the shoulders
    "neck": 0.052,
    "head": 0.13,
    "hip": 0.0955,  # from the middle to one side
    "thigh": 0.245,
    "shank": 0.246,
    "ankle": 0.039,  # its height above the sole
    "foot": 0.09,  # from below the ankle to the ball
    "toes": 0.04,
    "shoulder": 0.129,  # from the middle to one side
    "upper_arm": 0.186,
    "forearm": 0.146,
    "hand": 0.108,
}
