"""Statistics of poses: their principal components, regression with poses as targets, tests of two sets.

| module          |                                                                                          |
|-----------------|------------------------------------------------------------------------------------------|
| `_two_sample`   | the test of two sets; `_units` checks them, `_unit_means` compares them, `_permutations` |
|                 | has the p-value                                                                          |
"""

from skpose.statistics._two_sample import TwoSampleTest, two_sample_test

__all__ = ["TwoSampleTest", "two_sample_test"]
