"""The directive ``live``: a page of `skpose.view`, or one of this folder, by its name."""

import drop
import numpy as np
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from skpose import Motion, geodesic
from skpose.datasets import make_actions, make_gait
from skpose.motions import align_motions
from skpose.statistics import PoseTangentPCA
from skpose.view import explorer, player

RATE = 30  # Hz


def walk_and_run():
    """Return the page of a walk and a run of one generated person."""
    gait = make_gait(n_subjects=1, n_sequences=1, random_state=0)
    return player(gait, labels=list(gait.actions))


def actions():
    """Return the page of three actions next to each other."""
    shown = make_actions(1, 1, actions=["kick", "jump", "throw"], frame_rate=RATE, random_state=0)
    return player(shown, labels=list(shown.actions))


def aligned():
    """Return the page of two people's walks, played by the frames that belong together."""
    gait = make_gait(n_subjects=2, n_sequences=1, frame_rate=RATE, random_state=0)
    one, other = gait[gait.actions == "walk"].motions
    return player([one, other], labels=["Anna", "Ben"], alignment=align_motions(one, other))


def component():
    """Return the page of the poses along the first component of walking, there and back."""
    gait = make_gait(n_subjects=4, n_sequences=2, random_state=0)
    walks = gait[gait.actions == "walk"].poses(frame_rate=12)[0]
    pca = PoseTangentPCA(gait.skeleton, n_components=2).fit(walks)
    deviations = pca.transform(walks).std(axis=0)
    swings = 2.0 * np.sin(np.linspace(0.0, 2.0 * np.pi, 2 * RATE + 1))
    motions = [
        Motion(gait.skeleton, pca.inverse_transform(np.outer(swings, deviation)), RATE)
        for deviation in np.diag(deviations)
    ]
    return player(motions, labels=["first component", "second component"])


def path():
    """Return the page of a shortest path next to the straight line."""
    shown = make_actions(1, 1, actions=["kick", "throw"], frame_rate=RATE, random_state=0)
    kick, throw = (motion.angles[len(motion) // 2] for motion in shown)
    return player(geodesic(kick, throw, shown.skeleton))


def plane():
    """Return the explorer of people who do ten actions."""
    return explorer(make_actions(2, 2, random_state=0), frame_rate=8, metrics=["spatial", "angle"])


PAGES = {
    "walk": walk_and_run,
    "actions": actions,
    "aligned": aligned,
    "component": component,
    "path": path,
    "plane": plane,
    "drop": drop.page,
}


READS_ITS_FRAME = {"drop"}  # pages that follow the player in them, for which both need the origin of the site


def html_of(name):
    """Return the HTML that shows the page of a name, once it is near to what is seen."""
    html = PAGES[name]()._repr_html_().replace("<iframe ", '<iframe loading="lazy" ', 1)
    return html.replace('sandbox="', 'sandbox="allow-same-origin ', 1) if name in READS_ITS_FRAME else html


class Live(SphinxDirective):
    """Show a page in a frame of the page."""

    required_arguments = 1

    def run(self):
        name = self.arguments[0]
        return [nodes.container("", nodes.raw("", html_of(name), format="html"), classes=["live", name])]


def setup(app):
    app.add_directive("live", Live)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
