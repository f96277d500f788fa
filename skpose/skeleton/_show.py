"""Motions that show themselves. The pages are made by `skpose.view`, far below in the flow of data."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skpose.skeleton._motion import Motion
    from skpose.view import Page


def play(motion: "Motion") -> "Page":
    """Return a page that plays the motion, see `skpose.view.player`.

    Returns
    -------
    Page
        In a notebook it shows itself; elsewhere ``motion.play().open()`` shows it in the browser, and
        ``motion.play().save("view.html")`` writes it.

    Raises
    ------
    ValueError
        If the motion has no frames.

    Examples
    --------
    >>> from skpose.datasets import make_gait
    >>> make_gait(1, 1, random_state=0).motions[0].play().note
    '1 motion, positions within 0.027 mm'
    """
    from skpose.view import player

    return player(motion)


def strip(motion: "Motion") -> str:
    """Return some poses of the motion as a picture, which a notebook shows."""
    from skpose.view._shared import strip

    return strip(motion)
