"""Functions of the layers above skeletons, motions and keypoints that their methods call, filled in by `skpose`."""

from collections.abc import Callable
from typing import Any, TypeAlias

Page: TypeAlias = Any  # `skpose.view.Page`
Keypoints: TypeAlias = Any  # `skpose.keypoints.Keypoints`


class UpperLayers:
    """Functions that methods of skeletons, motions and keypoints call."""

    player: Callable[..., Page]  # `skpose.view.player`
    world_positions: Callable[..., Any]  # `skpose.kinematics._forward.world_positions`
    keypoints: Callable[..., Keypoints]
    mass_weights: Callable[..., Any]  # `skpose.kinematics._mass.mass_weights`


upper_layers = UpperLayers()
