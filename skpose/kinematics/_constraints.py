"""The constraint of the parameter `skeleton` of functions and estimators, for scikit-learn's validation."""

from skpose._compat.sklearn import InstanceOf
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import explain_no_skeleton

IS_SKELETON = InstanceOf(Skeleton, "skpose.Skeleton", explain_no_skeleton)
