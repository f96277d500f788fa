"""Statistics of poses: principal components, regression with poses as targets, tests of two sets.

| module              |                                                                     |
|---------------------|---------------------------------------------------------------------|
| `_tangent_pca`      | principal components, with the tangent vectors of each metric       |
| `_kernel_regressor` | poses as targets                                                    |
| `_two_sample`       | test of two sets; `_units` validates them and averages distances    |
| `_outliers`         | test of single motions against a set                                |
"""

from skpose.statistics._kernel_regressor import PoseKernelRegressor
from skpose.statistics._outliers import OutlierTestResult as OutlierTestResult, outlier_test
from skpose.statistics._tangent_pca import PoseTangentPCA
from skpose.statistics._two_sample import TwoSampleTestResult as TwoSampleTestResult, two_sample_test

__all__ = [
    "PoseKernelRegressor",
    "PoseTangentPCA",
    "outlier_test",
    "two_sample_test",
]
