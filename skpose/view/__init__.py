"""Pages for the browser: motions to look at, turn and compare.

Each function returns a `Page`, one HTML file without network access. No further packages are needed.

| module    |                                                                                          |
|-----------|------------------------------------------------------------------------------------------|
| `_player` | the player of motions, and of a geodesic and the straight line                         |
| `_explorer` | all poses of a collection of motions as points in the plane                            |
| `_scene`  | motions and keypoints in space, as pages draw them, and their numbers as text            |
| `_shape`  | the parts of figures: the head, trunk and limbs of people, and links of other skeletons  |
| `_page`   | one HTML file of markup, styles, scripts and data                                        |
| `assets`  | markup, styles and scripts: `page.js`, `figure.js` and `orbit.js` are for any page       |
"""

from skpose.view._explorer import explorer
from skpose.view._page import Page as Page
from skpose.view._player import player

__all__ = ["explorer", "player"]
