"""A robot for benchmarks that are given none: a humanoid of hinges in proportions of nobody, as an MJCF file.

Its links have the names of those of the Unitree G1 that `retarget` knows, so that it is found by these.
"""

from pathlib import Path

NAME = "stand_in"
# Of the left side: the link, the one that carries it, where it is, its axis and the range of its joint, degrees.
LEFT = (
    ("left_hip_pitch_link", "pelvis", (0.0, 0.06, -0.1), (0, 1, 0), (-120, 60)),
    ("left_hip_roll_link", "left_hip_pitch_link", (0.0, 0.05, 0.0), (1, 0, 0), (-30, 60)),
    ("left_hip_yaw_link", "left_hip_roll_link", (0.0, 0.0, -0.1), (0, 0, 1), (-90, 90)),
    ("left_knee_link", "left_hip_yaw_link", (0.0, 0.0, -0.2), (0, 1, 0), (0, 160)),
    ("left_ankle_pitch_link", "left_knee_link", (0.0, 0.0, -0.3), (0, 1, 0), (-50, 40)),
    ("left_ankle_roll_link", "left_ankle_pitch_link", (0.0, 0.0, -0.02), (1, 0, 0), (-20, 20)),
    ("left_shoulder_pitch_link", "torso_link", (0.0, 0.1, 0.25), (0, 0.96, 0.28), (-170, 150)),
    ("left_shoulder_roll_link", "left_shoulder_pitch_link", (0.0, 0.04, 0.0), (1, 0, 0), (-90, 130)),
    ("left_shoulder_yaw_link", "left_shoulder_roll_link", (0.0, 0.0, -0.1), (0, 0, 1), (-150, 150)),
    ("left_elbow_link", "left_shoulder_yaw_link", (0.0, 0.0, -0.1), (0, 1, 0), (-150, 10)),
    ("left_wrist_roll_link", "left_elbow_link", (0.0, 0.0, -0.1), (0, 0, 1), (-110, 110)),
    ("left_wrist_pitch_link", "left_wrist_roll_link", (0.0, 0.0, -0.1), (0, 1, 0), (-90, 90)),
    ("left_wrist_yaw_link", "left_wrist_pitch_link", (0.0, 0.0, -0.04), (1, 0, 0), (-90, 90)),
)
SOLID = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
TORSO = ("torso_link", "pelvis", (0.0, 0.0, 0.1), (0, 0, 1), (-150, 150))


def write_robot(folder):
    """Write the robot to a folder, and return the file's path."""
    links = [TORSO]
    for name, carrier, (x, y, z), (a, b, c), (low, high) in LEFT:
        links.append((name, carrier, (x, y, z), (a, b, c), (low, high)))
        # A mirror image: the range of an axis that the mirror turns round is negated, too.
        mirrored = (high * -1, low * -1) if b == 0 else (low, high)
        right = [text.replace("left", "right") for text in (name, carrier)]
        links.append((*right, (x, -y, z), (a, b, -c) if b else (a, b, c), mirrored))
    children = {}
    for link in links:
        children.setdefault(link[1], []).append(link)

    def text(link):
        name, _, place, axis, limits = link
        at, along, span = (" ".join(map(str, numbers)) for numbers in (place, axis, limits))
        inside = "".join(text(child) for child in children.get(name, ()))
        joint = f'<joint name="{name.removesuffix("_link")}_joint" axis="{along}" range="{span}"/>'
        return f'<body name="{name}" pos="{at}">{SOLID}{joint}{inside}</body>'

    inside = "".join(map(text, children["pelvis"]))
    root = f'<body name="pelvis" pos="0 0 0.8"><freejoint/>{SOLID}{inside}</body>'
    path = Path(folder, f"{NAME}.xml")
    path.write_text(f'<mujoco model="{NAME}"><worldbody>{root}</worldbody></mujoco>')
    return path
