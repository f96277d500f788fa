"""The root of a BVH file: the joint that carries the skeleton, or the one that the user names."""

import numpy as np
import pytest
from conftest import in_space

from skpose.io import MocapFormatError, load_bvh

N_FRAMES = 30
POSITIONS, ROTATIONS = ("Xposition", "Yposition", "Zposition"), ("Zrotation", "Yrotation", "Xrotation")
SIX = POSITIONS + ROTATIONS


class Node:
    """A joint of a file to be written, and the numbers of its channels, (n_frames, n_channels)."""

    def __init__(self, name, offset, channels, values, *children):
        self.name, self.offset, self.channels, self.children = name, offset, channels, children
        self.values = np.broadcast_to(np.asarray(values, dtype=float), (N_FRAMES, len(channels)))

    def lines(self, keyword="ROOT"):
        yield f"{keyword} {self.name} {{ OFFSET {' '.join(map(str, self.offset))}"
        yield f"CHANNELS {len(self.channels)} {' '.join(self.channels)}"
        for child in self.children:
            yield from child.lines("JOINT")
        if not self.children:
            yield "End Site { OFFSET 0 3 1 }"
        yield "}"

    def columns(self):
        return np.hstack([self.values, *(child.columns() for child in self.children)])

    def positions(self, frame, parent=None):
        """Yield names and positions in space, by products of 4 × 4 matrices, one channel after another."""
        moved, turned = np.array(self.offset, dtype=float), np.eye(4)
        for channel, value in zip(self.channels, self.values[frame], strict=True):
            axis = "XYZ".index(channel[0])
            if channel.endswith("position"):
                moved[axis] = value
            else:
                c, s = np.cos(np.radians(value)), np.sin(np.radians(value))
                one = np.eye(4)
                i, j = (axis + 1) % 3, (axis + 2) % 3
                one[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
                turned = turned @ one
        translated = np.eye(4)
        translated[:3, 3] = moved
        world = (np.eye(4) if parent is None else parent) @ translated @ turned
        yield self.name, world[:3, 3]
        for child in self.children:
            yield from child.positions(frame, world)
        if not self.children:
            yield f"{self.name}_end", (world @ [0, 3, 1, 1])[:3]


def text(root):
    frames = "\n".join(" ".join(f"{x:.9f}" for x in row) for row in root.columns())
    return "\n".join(["HIERARCHY", *root.lines(), "MOTION", f"Frames: {N_FRAMES}", "Frame Time: 0.1", frames, ""])


def movement(seed, n, scale):
    """Return smooth numbers (n_frames, n)."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, N_FRAMES)[:, None]
    return scale * (np.sin(2 * np.pi * (t + rng.uniform(size=n))) * rng.uniform(0.5, 1, n) + rng.normal(size=n))


def hips(*more, positions=True):
    """Return Hips with a Leg and a Spine with an Arm; the hips move by position channels, or not."""
    values = np.hstack([movement(0, 3, 50), movement(1, 3, 60)])
    arm = Node("Arm", (4, 1, 0), ROTATIONS, movement(2, 3, 60))
    spine = Node("Spine", (0, 10, 1), ROTATIONS[::-1], movement(3, 3, 60), arm)
    leg = Node("Leg", (2, -9, 0), ROTATIONS[:1], movement(4, 1, 60))
    where = slice(None) if positions else slice(3, None)
    return Node("Hips", (1, 2, 3), SIX[where], values[:, where], leg, spine, *more)


@pytest.fixture
def load(tmp_path):
    def load(tree, /, **options):
        (tmp_path / "a.bvh").write_text(tree if isinstance(tree, str) else text(tree))
        return load_bvh(tmp_path / "a.bvh", **options)

    return load


BELOW = ("Leg", "Leg_end", "Spine", "Arm", "Arm_end")


def assert_in_space(motion, root, names=BELOW, position="Hips"):
    """Check every joint's position, and that of the root, against the slow reference."""
    assert motion.skeleton.joint_names == names
    for frame in range(N_FRAMES):
        expected = dict(root.positions(frame))
        np.testing.assert_allclose(motion.root_positions[frame], expected[position], atol=1e-6)
        np.testing.assert_allclose(in_space(motion)[frame], [expected[name] for name in names], atol=1e-6)


STILL = np.zeros(6)
PLACED = np.array([5.0, -3, 2, 0, 0, 0])
TURNED = np.array([5.0, -3, 2, 30, -100, 40])


@pytest.mark.parametrize("above", [STILL, PLACED, TURNED, TURNED + 1e-5 * np.arange(N_FRAMES)[:, None]])
def test_a_reference_that_stands_still_is_not_the_root(above, load):
    root = Node("joint_Root", (0, 0, 1), SIX, above, hips())
    motion = load(root)
    assert_in_space(motion, root)
    np.testing.assert_allclose(load(root, root="Hips").angles, motion.angles)
    if not above[..., 3:].any():  # the hips' own numbers
        np.testing.assert_allclose(np.degrees(motion.root_angles), hips().values[:, 3:], atol=1e-8)
        assert motion.root_axes == "ZYX"
    assert np.abs(np.diff(motion.root_angles, axis=0)).max() < 1.0


def test_the_first_joint_stays_the_root(load):
    """Where it moves, has another child, or its child is not moved by position channels."""
    moving = Node("joint_Root", (0, 0, 0), SIX, np.hstack([movement(7, 3, 9), np.zeros((N_FRAMES, 3))]), hips())
    with pytest.raises(MocapFormatError):
        load(moving)
    prop = Node("Prop", (9, 0, 0), ROTATIONS, [1, 2, 3])
    with pytest.raises(MocapFormatError):
        load(Node("joint_Root", (0, 0, 0), SIX, STILL, hips(), prop))
    unmoved = Node("joint_Root", (0, 0, 0), SIX, STILL, hips(positions=False))
    assert_in_space(load(unmoved), unmoved, ("Hips", *BELOW), "joint_Root")
    nearly = Node("Hips", (1, 2, 3), SIX, hips().values * [1e-4, 0, 0, 1, 1, 1], *hips().children)  # not used, not zero
    skeleton = load(Node("joint_Root", (0, 0, 0), SIX, STILL, nearly)).skeleton
    np.testing.assert_array_equal(skeleton.offsets[skeleton.joint_names.index("Hips")], [1, 2, 3])
    plain = hips()
    assert_in_space(load(plain), plain)
    assert (
        load(Node("joint_Root", (0, 0, 0), SIX, STILL, hips()), root="joint_Root", stretch="mean").skeleton.n_joints
        == 6
    )


def test_the_movement_above_a_named_root_is_part_of_the_roots(load):
    """Positions in space are those of the file, also if all above moves."""
    above = np.hstack([movement(7, 3, 9), movement(8, 3, 100)])
    root = Node("joint_Root", (3, 0, 0), SIX, above, hips())
    motion = load(root, root="Hips")
    assert_in_space(motion, root)
    assert np.abs(np.diff(motion.root_angles, axis=0)).max() < np.pi  # continuous
    reference = Node("joint_Root", (3, 0, 0), SIX, above, hips(positions=False))
    assert_in_space(load(reference, root="Hips"), reference)


def test_branches_outside_a_named_root_are_left_out_with_a_warning(load):
    prop = Node("Prop", (9, 0, 0), SIX, movement(6, 6, 50))  # moves, which does not matter
    root = Node("Scene", (0, 0, 0), SIX, STILL, hips(), prop)
    with pytest.warns(UserWarning, match="root='Hips' leaves out .*Prop"):
        assert_in_space(load(root, root="Hips"), root)
    with pytest.warns(UserWarning, match="root='Spine' leaves out .*Leg"):
        motion = load(hips(), root="Spine")
    assert_in_space(motion, hips(), ("Arm", "Arm_end"), "Spine")
