"""What tests of the explorer in a browser share: what the page holds, where its points are, what is shown."""

import numpy as np
from pages import data_of

from skpose import forward_kinematics
from skpose.view._pack import unpack

SHOWN = "skpose.view.figures.map(({ points }) => points)"


class Held:
    """What a page holds, read by Python."""

    def __init__(self, page, skeleton):
        self.data, self.skeleton = data_of(page), skeleton
        self.X = unpack(self.data["poses"])
        self.motion_of = np.repeat(np.arange(len(self.data["counts"])), self.data["counts"])
        self.times = unpack(self.data["times"])[:, 0]

    def embedding(self, metric):
        (one,) = [one for one in self.data["embeddings"] if one["metric"] == metric]
        return unpack(one["points"])

    def rows(self, row):
        """Return the rows of a pose's motion."""
        return np.flatnonzero(self.motion_of == self.motion_of[row])

    def time(self, row):
        return self.times[row] - self.times[self.rows(row)[0]]

    def name(self, row):
        return f"{self.data['labels'][self.motion_of[row]]}, {self.time(row):.2f} s"

    def figure(self, pose):
        """Return the positions of root and joints as the page has them, y up."""
        up = self.data["up"]
        joints = forward_kinematics([pose], self.skeleton)[0][:, up["order"]] * up["signs"]
        return np.concatenate([np.zeros((1, 3)), joints])


def places(browser):
    """Return where the points are in the canvas, px."""
    browser.settle()
    return np.array(browser.js("Array.from({ length: skpose.poses.count }, (_, i) => skpose.stage.at(i))"))


def shown(browser):
    """Return the positions of root and joints of each figure that is shown."""
    browser.settle()
    return [np.array(points) for points in browser.js(SHOWN)]


def apart(where, least=9):
    """Return the points that are so far from all others, px, that a pointer finds no other one."""
    far = np.linalg.norm(where[:, None] - where, axis=2) + 1e9 * np.eye(len(where))
    return np.flatnonzero(far.min(axis=1) > least)


def click(browser, place, modifiers=0):
    place = tuple(map(float, place))
    browser.mouse(("moved", *place), ("pressed", *place), ("released", *place), modifiers=modifiers)


def drag(browser, *path, modifiers=0):
    path = [tuple(map(float, place)) for place in path]
    events = [("moved", *path[0]), ("pressed", *path[0])]
    browser.mouse(*events, *(("moved", *place) for place in path[1:]), ("released", *path[-1]), modifiers=modifiers)
