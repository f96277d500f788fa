"""Distances between human poses that measure how far the joints move, for scikit-learn.

The metrics of S. Hauberg and K. S. Pedersen, "Spatial measures between human poses for classification and
understanding", AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`. In the order in which data flows: files (`skpose.io`)
and datasets (`skpose.datasets`), `Skeleton` and `Motion`, kinematics, metrics, matrices of distances, estimators.

The names here are the stable core. All others live in their packages.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from skpose._utils.upper_layers import upper_layers as _upper_layers

__all__ = [
    "Bone",
    "Keypoints",
    "Motion",
    "PoseKNeighborsTransformer",
    "Skeleton",
    "forward_kinematics",
    "geodesic",
    "inverse_kinematics",
    "motion_distances",
    "pose_distances",
    "pose_metric",
]

# Each package is imported when it or one of its names is first used (PEP 562): the command line prints its help without
# numba and scikit-learn, which take a second.
if TYPE_CHECKING:
    from skpose import (
        biomechanics as biomechanics,
        checks as checks,
        cluster as cluster,
        datasets as datasets,
        geodesics as geodesics,
        io as io,
        keypoints as keypoints,
        kinematics as kinematics,
        manifold as manifold,
        metrics as metrics,
        motions as motions,
        neighbors as neighbors,
        plot as plot,
        preprocessing as preprocessing,
        robots as robots,
        scores as scores,
        skeleton as skeleton,
        statistics as statistics,
        view as view,
    )
    from skpose.geodesics import geodesic
    from skpose.keypoints import Keypoints
    from skpose.kinematics import forward_kinematics, inverse_kinematics
    from skpose.metrics import pose_distances, pose_metric
    from skpose.motions import motion_distances
    from skpose.neighbors import PoseKNeighborsTransformer
    from skpose.skeleton import Bone, Motion, Skeleton

    __version__: str
else:
    _PACKAGES = {
        "biomechanics": [],
        "checks": [],
        "cluster": [],
        "datasets": [],
        "geodesics": ["geodesic"],
        "io": [],
        "keypoints": ["Keypoints"],
        "kinematics": ["forward_kinematics", "inverse_kinematics"],
        "manifold": [],
        "metrics": ["pose_distances", "pose_metric"],
        "motions": ["motion_distances"],
        "neighbors": ["PoseKNeighborsTransformer"],
        "plot": [],
        "preprocessing": [],
        "robots": [],
        "scores": [],
        "skeleton": ["Bone", "Motion", "Skeleton"],
        "statistics": [],
        "view": [],
    }
    _PACKAGE_OF = {name: package for package, names in _PACKAGES.items() for name in names}

    def __getattr__(name):
        if name in _PACKAGES:
            return import_module(f"skpose.{name}")  # which makes it an attribute
        if name == "__version__":
            value = import_module("importlib.metadata").version("skpose")
        elif name in _PACKAGE_OF:
            value = getattr(import_module(f"skpose.{_PACKAGE_OF[name]}"), name)
        else:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = value
        return value

    def __dir__():
        own = {name for name in globals() if name.startswith("_")}  # without what is imported here
        return sorted({*own, *_PACKAGES, *__all__, "__version__"})


def _later(module, name):
    """A function whose module is imported at the first call."""
    return lambda *arguments, **options: getattr(import_module(f"skpose.{module}"), name)(*arguments, **options)


# Methods of skeletons, motions and keypoints that need what comes after them in the flow of data.
_upper_layers.player = _later("view", "player")
_upper_layers.world_positions = _later("kinematics._forward", "world_positions")
_upper_layers.mass_weights = _later("kinematics._mass", "mass_weights")
_upper_layers.keypoints = _later("keypoints", "Keypoints")
