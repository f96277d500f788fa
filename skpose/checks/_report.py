"""A page that lists findings and plays each at its frame."""

import html
from collections.abc import Callable, Sequence
from typing import Any
from urllib.parse import urlencode

from skpose.checks._findings import Finding
from skpose.kinematics._anatomy import joint_places
from skpose.skeleton import Motion
from skpose.view._page import Page, page_of
from skpose.view._player import ASSETS
from skpose.view._scene import motion_data

MOST = 300  # findings that are played
BEFORE, LONGEST = 1.0, 5.0  # s before and after a finding, and s that are played


def report(findings: Sequence[Finding], names: Sequence[str], motion_of: Callable[[int], Motion]) -> Page:
    """The page of findings, by the names of motions and a function that reads one of them."""
    clips: dict[str, dict] = {}
    rows, motions = [], dict[int, Motion]()
    for i, one in enumerate(findings):
        words = [one.severity, names[one.motion], f"{one.frames[0]} to {one.frames[1] - 1}", f"{one.kind}: {one.what}"]
        text = "".join(f"<span>{html.escape(word)}</span>" for word in words) + f"<em>{html.escape(one.remedy)}</em>"
        if one.frames[1] > one.frames[0] and len(clips) < MOST:
            if one.motion not in motions:
                motions = {one.motion: motion_of(one.motion)}  # findings of a motion follow each other
            clips[str(i)], link = _clip(one, motions[one.motion], names[one.motion])
            text = f'<a id="finding-{i}" href="#{html.escape(urlencode({"finding": i} | link))}">{text}</a>'
        rows.append(f'<li class="{one.severity}">{text}</li>')
    title = f"{len(findings)} findings in {len(names)} files"
    data: dict[str, Any] = {"title": title, "clips": clips, "motions": [], "alignment": None, "overlay": False}
    note = f"{len(clips)} of {len(findings)} findings are played"
    assets = [
        *ASSETS[: ASSETS.index("page.js") + 1],
        "findings.css",
        "findings.js",
        *ASSETS[ASSETS.index("page.js") + 1 :],
    ]
    markup = f'<nav aria-label="Findings"><ol>{"".join(rows)}</ol></nav>'
    return page_of(title, note, data, "player.html", assets, markup)


def _clip(finding: Finding, motion: Motion, name: str) -> tuple[dict, dict]:
    """The part of a motion around a finding, and the words of a link to it."""
    first, end = finding.frames
    around = round(BEFORE * motion.frame_rate)
    start = max(0, first - around)
    stop = min(end + around, start + round(LONGEST * motion.frame_rate))
    known = dict(zip(motion.skeleton.joint_names, joint_places(motion.skeleton), strict=True))
    link = {"t": f"{motion.times[first] - motion.times[start]:.4f}"}
    if finding.joints and finding.joints[0] in known:
        link |= {"joint": known[finding.joints[0]], "trails": "1"}
    return motion_data(motion[start:stop], name), link
