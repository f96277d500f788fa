"""What tests of the player in a browser share: its state, and where the camera has a point."""

import numpy as np
from scipy.spatial.transform import Rotation

LEFT, RIGHT = (0, 114, 178), (192, 79, 0)  # colours of the limbs on white
STATE = """({
  ticks: skpose.clock.count, tick: skpose.tick(), playing: skpose.state.playing,
  azimuth: skpose.stage.camera.azimuth, elevation: skpose.stage.camera.elevation, zoom: skpose.stage.camera.zoom,
  shift: skpose.stage.camera.shift, distance: skpose.stage.camera.distance,
  views: skpose.stage.views.map(({area, view, figures}) => ({
    area, target: view.target, points: figures.map((f) => f.points), clips: figures.map((f) => f.clip)
  })),
})"""


def state_of(browser):
    """Return the state of the player after it has drawn; `points` of a view are those of root and joints, y up, m."""
    browser.settle()
    return browser.js(STATE)


def projected(state, points, view=0):
    """Project points (n, 3) by the camera, from the textbook: rotate, move away, divide by the depth; px."""
    area = state["views"][view]["area"]
    turn = Rotation.from_euler("yx", [-state["azimuth"], state["elevation"]])
    seen = turn.apply(np.asarray(points) - state["views"][view]["target"])
    seen[:, :2] -= np.multiply(state["shift"], state["distance"])
    depth = state["distance"] / state["zoom"] - seen[:, 2]
    focal = min(area["width"], area["height"]) / 2 / np.tan(np.radians(15))
    middle = [area["x"] + area["width"] / 2, area["y"] + area["height"] / 2]
    return middle + focal * seen[:, :2] / depth[:, None] * [1, -1]
