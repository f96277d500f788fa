"""Check a built site: `python docs/check_pages.py docs/_build` prints what is wrong, and fails if anything is.

Of each page, as text: it loads nothing from the network, has a title of its own and no empty header of a table, shows
no LaTeX, links the names of functions, and has pictures that exist; each entry of the gallery has a picture.

In Chromium, if there is one: at the widths of a phone and of a laptop nothing is cut off or wider than the window, text
stands out from what is behind it in light and dark colours, no request leaves the folder, no script fails, the search
finds pages. Without Chromium it says so, and `--browser` makes that an error.
"""

import argparse
import re
import sys
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

from devtools import Window, chromium

WIDTHS = (420, 1300)
VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}
LATEX = re.compile(r"\\[A-Za-z]{2,}|\\[(\[]|\$[^$\n]+\$")
SOURCES = {("link", "href"), ("script", "src"), ("img", "src"), ("iframe", "src"), ("source", "src")}
# A link of a page to another site is none of these; nor is the address of this page, or of what it was made with.
PAGES_ONLY = {"canonical", "author", "search", "next", "prev", "index"}
# Words of code that are also names of the library, in pages where they mean something else.
PLAIN_WORDS = {"skpose"}


class Page(HTMLParser):
    """What a page loads and shows: addresses, text outside of code, headers of tables, code that is no link."""

    def __init__(self, text):
        super().__init__()
        self.loads, self.images, self.text, self.headers, self.code, self.titles = [], [], [], [], [], []
        self.heading = ""
        self._open = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        classes = set((given.get("class") or "").split())
        for name, value in attributes:
            if (tag, name) in SOURCES and not (tag == "link" and given.get("rel") in PAGES_ONLY):
                self.loads.append(value)
        if tag == "img":
            self.images.append(given.get("src"))
        if tag not in VOID:
            self._open.append((tag, classes))
            if tag == "th":
                self.headers.append("")
            if tag == "code" and "literal" in classes and not self._inside("a", "h1", "h2", "h3", "h4"):
                self.code.append("")

    def handle_endtag(self, tag):
        while self._open and any(name == tag for name, _ in self._open):
            if self._open.pop()[0] == tag:
                return

    def _inside(self, *tags):
        return any(name in tags for name, _ in self._open)

    def handle_data(self, data):
        if self._inside("title") and not self._inside("svg"):
            self.titles.append(data)
        if self._inside("h1"):
            self.heading += data
        if self._inside("th"):
            self.headers[-1] += data
        if self._inside("code") and "literal" in self._open_classes("code") and not self._inside("a", "h1", "h2", "h3"):
            self.code[-1] += data
        if not self._inside("code", "pre", "script", "style", "math", "title"):
            self.text.append(data)

    def _open_classes(self, tag):
        return next(classes for name, classes in reversed(self._open) if name == tag)


def is_external(address):
    return bool(re.match(r"(https?:)?//", address or ""))


def public_names(site):
    """Return the names of the pages of the reference, whole and without their package."""
    pages = [path.stem for path in (site / "api").glob("*.html")]
    return set(pages) | {name.split(".")[-1] for name in pages}


def problems_of_text(site, path, names):
    """Yield what is wrong with a page as it is written."""
    page = Page(path.read_text(encoding="utf-8"))
    for address in page.loads:
        if is_external(address):
            yield f"loads {address} from the network"
    title = "".join(page.titles).strip()
    if not title or not page.heading.strip():
        yield "has no title"
    for text in page.text:
        found = LATEX.search(text)
        if found:
            yield f"shows LaTeX: {found.group()!r}"
    if any(not header.strip() for header in page.headers):
        yield "has a table with an empty header"
    for address in page.images:
        if address and not is_external(address) and not address.startswith("data:"):
            target = (path.parent / unquote(address.split("?")[0].split("#")[0])).resolve()
            if not target.is_file():
                yield f"shows a picture that is not there: {address}"
            elif re.fullmatch(r"sphx_glr_.*thumb\.\w+", target.name):
                placeholders = [site / "_static" / name for name in ("no_image.png", "broken_example.png")]
                if any(p.is_file() and p.read_bytes() == target.read_bytes() for p in placeholders):
                    yield f"shows a placeholder: {address}"
    if path.parent == site:
        for code in page.code:
            name = re.fullmatch(r"([A-Za-z_][\w.]*)(\(.*\))?", code, flags=re.DOTALL)
            if name and name[1] in names - PLAIN_WORDS:
                yield f"names {code!r} without a link"


# The elements that are cut off or stick out. A box that scrolls is whole, but the keyboard must reach it, and it must
# have a name; titles, code and lists of contents must fit, and the text of a page is no such box. Formulas and pictures
# are one thing each, and the drawer of a phone waits next to the window.
MEASURE = """
(() => {
  const root = document.documentElement, width = root.clientWidth, found = [];
  const name = (e) => `${e.tagName.toLowerCase()}.${e.className} "${e.textContent.trim().slice(0, 40)}"`;
  const overflow = (e, ...kinds) => kinds.includes(getComputedStyle(e).overflowX);
  const box = (e) => overflow(e, "auto", "scroll") && !e.querySelector("h1");
  const scrolls = (e) => e && (box(e) || scrolls(e.parentElement));
  if (root.scrollWidth > width) found.push(`the page is ${root.scrollWidth} px wide`);
  for (const e of document.querySelectorAll("body *")) {
    const {width: wide, height: high, left, right} = e.getBoundingClientRect();
    if (wide < 2 || high < 2) continue;
    if (!e.checkVisibility({visibilityProperty: true, opacityProperty: true})) continue;
    const apart = e.closest("svg *, math *, .bd-sidebar-primary, .pst-sidebar-drawer");
    const whole = /^(H[1-6]|PRE)$/.test(e.tagName), out = right > width + 1 || left < -1;
    const shown = whole || e.closest(".bd-sidebar-secondary") || !scrolls(e.parentElement);
    if (out && shown && !apart) found.push(`sticks out: ${name(e)}`);
    if ((whole || overflow(e, "hidden", "clip")) && e.scrollWidth > e.clientWidth + 1)
      found.push(`cut off: ${name(e)}`);
    if (!whole && box(e) && e.scrollWidth > e.clientWidth + 1 && !(e.tabIndex === 0 && e.ariaLabel))
      found.push(`scrolls, but has no name for the keyboard: ${name(e)}`);
    if (e.tagName === "IMG" && e.complete && !e.naturalWidth) found.push(`no picture: ${e.src}`);
  }
  const bar = document.querySelector(".bd-header");
  if (bar && bar.getBoundingClientRect().height > 100) found.push("the top bar has two lines");
  return found;
})()
"""

# Text with less contrast than WCAG 2 asks for at level AA. One pixel blends the backgrounds behind a text, the
# outermost first, and the text, so that colours of all notations can be compared. Gradients and pictures are not seen.
CONTRAST = """
(() => {
  const canvas = Object.assign(document.createElement("canvas"), {width: 1, height: 1});
  for (const change of document.getAnimations()) if (change instanceof CSSTransition) change.finish();
  const pixel = canvas.getContext("2d", {willReadFrequently: true}), papers = new Map(), found = new Set();
  const painted = (...colours) => {
    for (const [colour, alpha] of colours) {
      Object.assign(pixel, {fillStyle: colour, globalAlpha: alpha});
      pixel.fillRect(0, 0, 1, 1);
    }
    return `rgb(${pixel.getImageData(0, 0, 1, 1).data.slice(0, 3).join()})`;
  };
  const paper = (e) => {
    if (!e) return "white";
    if (!papers.has(e)) papers.set(e, painted([paper(e.parentElement), 1], [getComputedStyle(e).backgroundColor, 1]));
    return papers.get(e);
  };
  const opacity = (e) => (e ? getComputedStyle(e).opacity * opacity(e.parentElement) : 1);
  const luminance = (rgb) => rgb.match(/\\d+/g).map((v) => v / 255)
    .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0.05);
  for (const e of document.querySelectorAll("body *")) {
    const box = e.getBoundingClientRect(), style = getComputedStyle(e);
    const text = [...e.childNodes].filter((node) => node.nodeType === 3).map((node) => node.data.trim()).join("");
    if (!text || box.width < 2 || e.closest("svg, script, style, :disabled")) continue;
    if (!e.checkVisibility({visibilityProperty: true, opacityProperty: true})) continue;
    const inks = [paper(e), painted([paper(e), 1], [style.color, opacity(e)])].map(luminance);
    const ratio = Math.max(...inks) / Math.min(...inks);
    const large = parseFloat(style.fontSize) >= (style.fontWeight >= 700 ? 18.66 : 24);
    if (ratio >= (large ? 3 : 4.5)) continue;
    const name = `${e.tagName.toLowerCase()}.${e.className} "${text.slice(0, 40)}"`;
    found.add(`${ratio.toFixed(1)} is too little contrast: ${name}`);
  }
  return [...found];
})()
"""


def problems_in_browser(window, path, width, dark):
    """Yield what is wrong with a page in a window of a width in pixels, in light or dark colours."""
    window.open(path.as_uri(), width, dark=dark, still=True)  # players that play take most of the time
    for text in window.run(MEASURE):
        yield f"{width} px: {text}"
    for text in window.run(CONTRAST):
        yield f"{'dark' if dark else 'light'}: {text}"
    for address in window.requests():
        if not address.startswith(("file:", "data:", "blob:")):
            yield f"asks the network for {address}"
    for text in window.errors():
        yield f"{width} px: error in the console: {text.splitlines()[0]}"


def problems_of_search(window, site, word, patience):
    """Yield what is wrong with the search of the site, which answers within some seconds."""
    window.open((site / "search.html").as_uri() + f"?q={word}")
    try:
        window.wait_for("document.querySelectorAll('#search-results li a').length > 0", patience)
    except TimeoutError:
        yield f"finds nothing for {word!r}"
    for text in window.run(CONTRAST):
        yield text
    for address in window.requests():
        if not address.startswith(("file:", "data:")):
            yield f"asks the network for {address}"
    for text in window.errors():
        yield f"error in the console: {text.splitlines()[0]}"


def check(site, window=None, widths=WIDTHS, search="geodesic", patience=20.0):
    """Return "page: problem" for all that is wrong with a site; its pages in a browser too, if there is one."""
    site = Path(site).resolve()
    pages = sorted(path for path in site.rglob("*.html") if "_static" not in path.relative_to(site).parts)
    names, found = public_names(site), []
    for path in pages:
        problems = list(problems_of_text(site, path, names))
        views = [(width, False) for width in widths] + [(widths[-1], True)]
        for width, dark in views if window else ():
            problems += problems_in_browser(window, path, width, dark)
        found += [f"{path.relative_to(site)}: {text}" for text in dict.fromkeys(problems)]
    titles = Counter("".join(Page(path.read_text(encoding="utf-8")).titles).strip() for path in pages)
    found += [f"{n} pages have the title {title!r}" for title, n in titles.items() if n > 1]
    if window and search and (site / "search.html").is_file():
        found += [f"search.html: {text}" for text in problems_of_search(window, site, search, patience)]
    return found, len(pages)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("site", type=Path)
    parser.add_argument("--browser", action="store_true", help="fail without Chromium")
    options = parser.parse_args()
    if not (options.site / "index.html").is_file():
        sys.exit(f"{options.site} is no built site: it has no index.html")
    if chromium():
        with Window() as window:
            problems, n_pages = check(options.site, window)
        how = f"in Chromium, {' and '.join(map(str, WIDTHS))} px wide"
    elif options.browser:
        sys.exit("no Chromium: install it, or name it in CHROMIUM")
    else:
        problems, n_pages = check(options.site)
        how = "without Chromium: widths, requests and the search are not checked"
    print(*problems, sep="\n", end="\n" if problems else "")
    print(f"{n_pages} pages, {how}: {len(problems)} problems")
    sys.exit(bool(problems))
