"""The check of the built site finds what is wrong with a page, and nothing in a page that is right."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))

from check_pages import check  # noqa: E402
from devtools import Window, chromium  # noqa: E402

NARROW = 420
RIGHT = """<!doctype html><html><head><title>{title}</title><meta name="viewport" content="width=device-width"></head>
<body style="margin: 8px; font: 16px sans-serif">{body}</body></html>"""
GOOD = """<h1>A title</h1><p>Text, 5 $ and <code class="literal">C:\\\\new</code>, <math><mi>θ</mi></math>.</p>
<pre style="white-space: pre-wrap">short</pre>
<div style="overflow-x: auto" tabindex="0" aria-label="Table: names">
<table><tr><th>name</th></tr><tr><td style="min-width: 900px">wide</td></tr></table></div>
<p><a href="https://example.org">a link</a> to
<a href="api/skpose.geodesic.html"><code class="literal">geodesic(a, b)</code></a></p>
<div style="width: 1px; height: 1px; overflow: hidden">read aloud</div>"""


def site(folder, body, title="A page", **files):
    """Write a site of one page, the page of a function, and other files."""
    (folder / "api").mkdir()
    (folder / "_static").mkdir()
    (folder / "index.html").write_text(RIGHT.format(title=title, body=body), encoding="utf-8")
    of_function = RIGHT.format(title="geodesic", body="<h1>geodesic</h1>")
    (folder / "api" / "skpose.geodesic.html").write_text(of_function, encoding="utf-8")
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text, encoding="utf-8")
    return folder


def problems(folder, window=None):
    return check(folder, window, widths=(NARROW,), search=None)[0]


@pytest.fixture(scope="module")
def window():
    if chromium() is None:
        pytest.skip("no Chromium: install it, or name it in the variable CHROMIUM")
    with Window() as one:
        yield one


def test_a_page_that_is_right(tmp_path):
    assert problems(site(tmp_path, GOOD)) == []


WRONG = {
    "a script of the network": ('<script src="https://cdn.org/a.js"></script>', "loads https://cdn.org/a.js from the"),
    "a style of the network": ('<link rel="stylesheet" href="//cdn.org/a.css">', "loads //cdn.org/a.css from the"),
    "a picture of the network": ('<img src="http://a.org/a.png">', "loads http://a.org/a.png from the network"),
    "LaTeX": (r"<p>the angle \theta</p>", r"shows LaTeX: '\\theta'"),
    "a formula in dollars": ("<p>with $a + b$ metres</p>", "shows LaTeX: '$a + b$'"),
    "an empty header": ("<table><tr><th></th><th>b</th></tr></table>", "has a table with an empty header"),
    "a name without a link": ('<p><code class="literal">geodesic(a, b)</code></p>', "names 'geodesic(a, b)' without"),
    "no picture": ('<img src="nowhere.png">', "shows a picture that is not there: nowhere.png"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_in_the_text(tmp_path, name):
    body, expected = WRONG[name]
    (found,) = problems(site(tmp_path, GOOD + body))
    assert found.startswith("index.html: ")
    assert expected in found


def test_titles_are_there_and_differ(tmp_path):
    assert problems(site(tmp_path, "<p>no title</p>")) == ["index.html: has no title"]
    shutil.copy(tmp_path / "api" / "skpose.geodesic.html", tmp_path / "again.html")
    assert "2 pages have the title 'geodesic'" in problems(tmp_path)


def test_an_entry_of_the_gallery_without_a_picture(tmp_path):
    body = GOOD + '<img src="sphx_glr_walk_thumb.png">'
    files = {"sphx_glr_walk_thumb__png": "nothing to see", "_static/no_image__png": "nothing to see"}
    folder = site(tmp_path, body, **files)
    assert problems(folder) == ["index.html: shows a placeholder: sphx_glr_walk_thumb.png"]
    (folder / "sphx_glr_walk_thumb.png").write_text("a picture")
    assert problems(folder) == []


def test_a_page_that_is_right_in_a_browser(tmp_path, window):
    assert problems(site(tmp_path, GOOD), window) == []


CUT_OFF = {
    "a wide element": (
        '<div style="width: 600px; height: 9px">a</div>',
        ["the page is 608 px wide", "sticks out: div"],
    ),
    "a long line of code": (f'<pre style="overflow-x: auto">{"long " * 40}</pre>', ["cut off: pre"]),
    "a title that scrolls": (f'<div style="overflow-x: auto"><h2>{"Long" * 40}</h2></div>', ["cut off: h2"]),
    "text behind an edge": (f'<p style="overflow: hidden; white-space: nowrap">{"long " * 40}</p>', ["cut off: p"]),
    "a box without a name": (
        '<div style="overflow-x: auto"><table><tr><td style="min-width: 900px">wide</td></tr></table></div>',
        ["scrolls, but has no name for the keyboard: div"],
    ),
    "a page that scrolls": (
        '<main style="overflow-x: auto"><h1>Main</h1><p style="width: 600px">wide</p></main>',
        ["sticks out: p"],
    ),
    "a script that fails": ("<script>missing()</script>", ["error in the console: ReferenceError: missing is not def"]),
    "a request by a script": (
        "<script>fetch('http://127.0.0.1:9/a').catch(() => {})</script>",
        ["asks the network for http://127.0.0.1:9/a"],
    ),
}


@pytest.mark.parametrize("name", CUT_OFF)
def test_what_is_wrong_in_a_window(tmp_path, window, name):
    body, expected = CUT_OFF[name]
    found = problems(site(tmp_path, GOOD + body), window)
    for text in expected:
        assert any(text in line for line in found), found


def test_boxes_of_the_site_have_a_name_while_they_scroll(tmp_path, window):
    boxes = """<section><h2>Numbers<a href="#">#</a></h2>
    <div class="pst-scrollable-table-container" style="overflow-x: auto">
    <table><tr><td style="min-width: 900px">wide</td></tr></table></div>
    <div class="math" style="overflow-x: auto"><p style="width: 900px">a formula</p></div></section>"""
    script = (DOCS / "_static" / "scrolls.js").read_text(encoding="utf-8")
    folder = site(tmp_path, f"{GOOD}{boxes}<script>{script}</script>")
    assert problems(folder, window) == []
    names = "[...document.querySelectorAll('section [role=region][tabindex]')].map((box) => box.ariaLabel)"
    for width in (1300, NARROW):
        window.open((folder / "index.html").as_uri(), width)
        for now in (1300, NARROW, 1300):
            size = {"width": now, "height": 900, "deviceScaleFactor": 1, "mobile": False}
            window.call("Emulation.setDeviceMetricsOverride", **size)
            expected = [] if now == 1300 else ["Table: Numbers", "Formula: Numbers"]
            window.wait_for(f"{names}.join() === '{','.join(expected)}'")


WHITE, BLACK = (255, 255, 255), (0, 0, 0)
COLOURS = {  # style of a text; its colour and what is behind it, blended by hand; the least ratio
    "grey": ("color: #777", (119, 119, 119), WHITE, 4.5),
    "a bit darker": ("color: #767676", (118, 118, 118), WHITE, 4.5),
    "large": ("color: #949494; font-size: 24px", (148, 148, 148), WHITE, 3.0),
    "large and bold": ("color: #777; font-size: 19px; font-weight: 700", (119, 119, 119), WHITE, 3.0),
    "not large": ("color: #777; font-size: 19px", (119, 119, 119), WHITE, 4.5),
    "too light even if large": ("color: #969696; font-size: 24px", (150, 150, 150), WHITE, 3.0),
    "on a background": ("color: #fff; background: #008000", WHITE, (0, 128, 0), 4.5),
    "on half of a background": ("color: #fff; background: rgb(0 128 0 / 50%)", WHITE, (127, 191, 127), 4.5),
    "on a mixture": ("background: color-mix(in srgb, #fff 40%, #000); color: #000", BLACK, (102, 102, 102), 4.5),
    "transparent": ("color: #000; opacity: 0.4", (153, 153, 153), WHITE, 4.5),
    "hidden": ("color: #fff; visibility: hidden", BLACK, WHITE, 4.5),
    "read aloud": ("color: #fff; width: 1px; height: 1px; overflow: hidden", BLACK, WHITE, 4.5),
}


def luminance(colour):
    """Relative luminance of WCAG 2."""
    linear = [v / 255 / 12.92 if v / 255 <= 0.03928 else ((v / 255 + 0.055) / 1.055) ** 2.4 for v in colour]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("name", COLOURS)
def test_texts_stand_out_from_what_is_behind(tmp_path, window, name):
    style, ink, paper, least = COLOURS[name]
    low, high = sorted([luminance(ink), luminance(paper)])
    ratio = (high + 0.05) / (low + 0.05)
    found = problems(site(tmp_path, GOOD + f'<p style="{style}">some text</p>'), window)
    if ratio >= least:
        assert found == []
    else:
        text = f'{ratio:.1f} is too little contrast: p. "some text"'
        assert found == [f"index.html: {theme}: {text}" for theme in ("light", "dark")]


def test_texts_stand_out_in_dark_colours_too(tmp_path, window):
    style = "<style>@media (prefers-color-scheme: dark) { html { background: #111; color: #444 } p { color: #fff } }"
    (found,) = problems(site(tmp_path, f"<h1 style='color: inherit'>A title</h1><p>a text</p>{style}</style>"), window)
    assert found == 'index.html: dark: 1.9 is too little contrast: h1. "A title"'


def test_colours_are_those_at_the_end_of_a_change(tmp_path, window):
    text = '<p id="text" style="color: #fff; transition: color 60s">some text</p>'
    script = "<script>getComputedStyle(text).color; text.style.color = '#000'</script>"
    assert problems(site(tmp_path, GOOD + text + script), window) == []


def test_the_top_bar_has_one_line(tmp_path, window):
    bar = '<div class="bd-header" style="height: {}px">bar</div>'
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    assert problems(site(tmp_path / "one", GOOD + bar.format(80)), window) == []
    (found,) = problems(site(tmp_path / "two", GOOD + bar.format(130)), window)
    assert found == "index.html: 420 px: the top bar has two lines"


def test_the_search_must_find_something(tmp_path, window):
    folder = site(tmp_path, GOOD)
    page = '<h1>Search</h1><div id="search-results">{} pages found<ul>{}</ul></div>'
    for links, wrong in (('<li><a href="index.html">A title</a></li>', 0), ("", 1)):
        text = RIGHT.format(title="Search", body=page.format(1 - wrong, links))
        (folder / "search.html").write_text(text, encoding="utf-8")
        found, _ = check(folder, window, widths=(NARROW,), patience=0.3)
        assert found == ["search.html: finds nothing for 'geodesic'"] * wrong


def test_the_command_fails_with_the_problems(tmp_path):
    folder = site(tmp_path, GOOD + WRONG["LaTeX"][0])
    command = [sys.executable, str(DOCS / "check_pages.py")]
    done = subprocess.run([*command, str(folder)], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stdout.startswith("index.html: shows LaTeX")
    assert ": 1 problems" in done.stdout
    done = subprocess.run([*command, str(tmp_path / "api")], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, f"{tmp_path / 'api'} is no built site: it has no index.html\n")
