"""Functions of the layers above skeletons, motions and keypoints that their methods call, filled in by `skpose`."""

from types import SimpleNamespace
from typing import Any, TypeAlias

Page: TypeAlias = Any  # `skpose.view.Page`
Keypoints: TypeAlias = Any  # `skpose.keypoints.Keypoints`

upper_layers: Any = SimpleNamespace()  # `player`, `world_positions`, `keypoints` and `mass_weights`
