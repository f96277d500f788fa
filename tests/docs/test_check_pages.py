"""The check of the built site finds what is wrong with a page, and nothing in a page that is right."""

import shutil
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


@pytest.mark.slow
def test_a_page_that_is_right_in_a_browser(tmp_path, window):
    assert problems(site(tmp_path, GOOD), window) == []


CUT_OFF = {
    "a wide element": (
        '<div style="width: 600px; height: 9px">a</div>',
        ["the page is 608 px wide", "sticks out: div"],
    ),
    "a long line of code": (f'<pre style="overflow-x: auto">{"long " * 40}</pre>', ["cut off: pre"]),
    "a box without a name": (
        '<div style="overflow-x: auto"><table><tr><td style="min-width: 900px">wide</td></tr></table></div>',
        ["scrolls, but has no name for the keyboard: div"],
    ),
    "a script that fails": ("<script>missing()</script>", ["error in the console: ReferenceError: missing is not def"]),
    "a request by a script": (
        "<script>fetch('http://127.0.0.1:9/a').catch(() => {})</script>",
        ["asks the network for http://127.0.0.1:9/a"],
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CUT_OFF)
def test_what_is_wrong_in_a_window(tmp_path, window, name):
    body, expected = CUT_OFF[name]
    found = problems(site(tmp_path, GOOD + body), window)
    for text in expected:
        assert any(text in line for line in found), found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("style", "ratio"),
    [("color: #777", 4.5), ("color: #767676", None), ("color: #777; font-size: 24px", None), ("opacity: 0.4", 2.8)],
)
def test_texts_stand_out_from_what_is_behind(tmp_path, window, style, ratio):
    """By WCAG 2: black at an opacity of 0.4 is #999, whose contrast with white is 2.8."""
    found = problems(site(tmp_path, GOOD + f'<p style="{style}">some text</p>'), window)
    text = f'{ratio} is too little contrast: p. "some text"'
    assert found == ([f"index.html: {theme}: {text}" for theme in ("light", "dark")] if ratio else [])


@pytest.mark.slow
def test_the_search_must_find_something(tmp_path, window):
    folder = site(tmp_path, GOOD)
    page = '<h1>Search</h1><div id="search-results">{} pages found<ul>{}</ul></div>'
    for links, wrong in (('<li><a href="index.html">A title</a></li>', 0), ("", 1)):
        text = RIGHT.format(title="Search", body=page.format(1 - wrong, links))
        (folder / "search.html").write_text(text, encoding="utf-8")
        found, _ = check(folder, window, widths=(NARROW,), patience=0.3)
        assert found == ["search.html: finds nothing for 'geodesic'"] * wrong
