"""Statistics of poses: their principal components, regression with poses as targets, tests of two sets.

| module              |                                                                                          |
|---------------------|------------------------------------------------------------------------------------------|
| `_tangent_pca`      | principal components; `_spaces` has the vectors that stand for poses, by metric          |
| `_kernel_regressor` | poses as targets; `_kernel_weights` has the weights of the training poses                |
| `_two_sample`       | the test of two sets; `_units` checks them, `_unit_means` compares them, `_permutations` |
|                     | has the p-value                                                                          |
| `_outliers`         | the test of each motion by itself against a set, by the same units and means             |
"""

from skpose.statistics._kernel_regressor import PoseKernelRegressor
from skpose.statistics._outliers import OutlierTestResult as OutlierTestResult
from skpose.statistics._outliers import outlier_test
from skpose.statistics._tangent_pca import PoseTangentPCA
from skpose.statistics._two_sample import TwoSampleTestResult as TwoSampleTestResult
from skpose.statistics._two_sample import two_sample_test

__all__ = [
    "PoseKernelRegressor",
    "PoseTangentPCA",
    "outlier_test",
    "two_sample_test",
]
