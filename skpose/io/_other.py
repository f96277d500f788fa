"""Text files of positions that are no motions: what they are, and the functions that read them."""

from skpose.io._keypoints_csv import is_table
from skpose.io._words import NUMBER, WHOLE

LOOKED_AT = 50  # lines; more say no more
NUMBERS = (
    "a table of numbers without names, such as Kinect's text of joints: numpy.loadtxt reads it, where rows are joints "
    "of x, y, z and how sure, and skpose.keypoints.Keypoints(table.reshape(-1, 20, 4)[:, :, :3], names, frame_rate) "
    "names them; layouts['kinect20'] is the skeleton"
)


def is_numbers(head: str) -> bool:
    """Return whether the first lines are numbers alone, some of them several on a line; frames of AMC have words."""
    lines = [line.replace(",", " ").split() for line in head.splitlines()[:LOOKED_AT] if line.strip()]
    if head.count("\n") < LOOKED_AT and len(lines) > 1:
        lines = lines[: len(lines) - (not head.endswith("\n"))]  # the last one may be cut
    return (
        bool(lines)
        and any(len(words) > 1 for words in lines)
        and all(NUMBER.fullmatch(word) for words in lines for word in words)
    )


def route_of(head: str) -> str | None:
    """Return what a text file of positions is, with the function that reads it; None for any other."""
    if head.lstrip()[:1] in ("{", "["):
        return "this is JSON: load_keypoints reads keypoints of OpenPose, MediaPipe and COCO in three dimensions"
    if is_numbers(head):
        return f"this is {NUMBERS}"
    if not WHOLE.fullmatch(next(iter(head.split(maxsplit=1)), "")) and is_table(head):
        return "this is a table with a header (CSV): load_keypoints reads positions of points"
    return None
