"""The content of an Acclaim skeleton file (ASF), and the `Skeleton` that it describes.

A bone b of an ASF file rotates with its own dofs, in axes C_b that the file gives in global coordinates: its world
rotation is R_b = R_parent · C_b · M_b · C_bᵀ, where M_b is the product of its dofs' rotations, and its far end is at
R_b · direction · length from its near end. In the terms of `Bone` the joint's own axes are H_b = R_b · C_b, so that the
rest rotation is C_parentᵀ · C_b and the offset C_bᵀ · direction · length. Euler angles are extrinsic in the order of
the bone's `axis` line.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.io._words import Token
from skpose.skeleton import Bone, Skeleton

ROTATIONS = ("rx", "ry", "rz")
CHANNELS = ("tx", "ty", "tz", *ROTATIONS)


@dataclass
class AcclaimBone:
    """One begin … end block of :bonedata."""

    begin: Token
    name: str
    direction: np.ndarray  # of length 1
    length: float  # in the file's unit
    axis: Rotation = field(default_factory=Rotation.identity)  # C_b
    order: str = "xyz"
    dofs: list[str] = field(default_factory=list)
    limits: list[float] = field(default_factory=list)  # low and high of each dof, in the file's unit of angles


@dataclass
class AcclaimRoot:
    """The :root section."""

    channels: list[str] = field(default_factory=lambda: list(CHANNELS))  # in the order of the AMC file's numbers
    order: str = "xyz"
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))  # in the file's unit
    orientation: np.ndarray = field(default_factory=lambda: np.zeros(3))  # about x, y, z, in the file's unit

    @property
    def axes(self) -> str:
        return "".join(axis for axis in self.order if f"r{axis}" in self.channels)


@dataclass(frozen=True, eq=False)
class Acclaim:
    """The content of an ASF file that an AMC file needs; its skeletons are built once."""

    name: str  # of the file, without its folder
    bones: dict[str, AcclaimBone]
    parents: dict[str, str | None]
    scale: float  # m per unit of length
    radians: bool | None  # None if the file does not state the unit of angles
    root: AcclaimRoot

    @property
    def channels(self) -> dict[str, list[str]]:
        """Channels of the root and of each bone with dofs, in the order of the numbers in an AMC file."""
        return {"root": self.root.channels} | {name: bone.dofs for name, bone in self.bones.items() if bone.dofs}

    @cached_property
    def skeleton(self) -> Skeleton:
        return Skeleton([self._bone(name) for name in self.bones])

    def _bone(self, name: str) -> Bone:
        bone, parent = self.bones[name], self.parents[name]
        parent_axis = Rotation.identity() if parent is None else self.bones[parent].axis
        order = [axis for axis in bone.order if f"r{axis}" in bone.dofs]
        limits: np.ndarray | None = None
        if bone.limits:
            pairs = dict(zip(bone.dofs, np.reshape(bone.limits, (-1, 2)), strict=True))
            limits = np.array([pairs[f"r{axis}"] for axis in order])
            limits = limits if self.radians else np.radians(limits)
        rest = (parent_axis.inv() * bone.axis).as_matrix()
        offset = bone.axis.inv().apply(bone.direction * (bone.length * self.scale))
        return Bone(name, parent, tuple(offset), "".join(order), rest, limits)

    @cached_property
    def with_three_dofs(self) -> "Acclaim":
        """The same with three dofs for every bone that has any: its own first, then the others, without limits."""
        if all(len(bone.dofs) in (0, 3) for bone in self.bones.values()):
            return self
        bones = {}
        for name, bone in self.bones.items():
            more = [dof for dof in ROTATIONS if dof not in bone.dofs] if bone.dofs else []
            limits = bone.limits + [-np.inf, np.inf] * len(more) if bone.limits else []
            bones[name] = replace(bone, dofs=bone.dofs + more, limits=limits)
        return replace(self, bones=bones)
