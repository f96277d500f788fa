"""Configuration of the site. Build it with sphinx-build -W docs docs/_build; no network is needed."""

import os
import sys
import warnings
from importlib.metadata import version as installed
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

import tiles

project = "skpose"
author = copyright = "The skpose developers"
version = release = installed("skpose")

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.extlinks",
    "numpydoc",
    "myst_parser",
    "sphinx_gallery.gen_gallery",
    "api_links",
    "column_names",
    "mathml",
    "live_pages",
    "search_order",
    "tiles",
]
html_math_renderer = "mathml"
extlinks = {"doi": ("https://doi.org/%s", "doi:%s")}
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build", "_extensions", "**sg_execution_times.rst"]
templates_path = ["_templates"]
myst_enable_extensions = ["attrs_block", "attrs_inline", "colon_fence", "dollarmath"]
myst_heading_anchors = 3
default_role = "py:obj"
toc_object_entries_show_parents = "hide"
autosummary_generate = True
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

html_theme = "pydata_sphinx_theme"
html_title = f"skpose {version}"
html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["skpose.css"]
html_js_files = ["offline.js", "scrolls.js"]
html_baseurl = "https://skpose.github.io/skpose"
html_favicon = "_static/icon.svg"
html_search_scorer = str(Path(__file__).parent / "scorer.js")
html_theme_options = {
    "navbar_center": ["bar"],
    "github_url": "https://github.com/skpose/skpose",
    "logo": {"text": "skpose"},
    "navbar_align": "left",
    "navigation_with_keys": False,
    "show_prev_next": False,
    "show_toc_level": 2,
}
html_context = {
    "pages_of_bar": [
        ("guide", "Guide"),
        ("drop", "Your files"),
        ("recipes", "Recipes"),
        ("examples/index", "Examples"),
        ("motions", "Motions"),
        ("keypoints", "Keypoints"),
        ("formats", "Formats"),
        ("theory", "Theory"),
        ("api", "API"),
        ("changelog", "Changelog"),
    ],
    "summary": "Distances between human poses that measure how far the joints move, as a part of scikit-learn",
}
html_sidebars = {page: [] for page in ("index", "drop", "theory", "changelog", "search", "genindex", "examples/**")}

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "examples",
    "filename_pattern": r"\.py$",
    "image_scrapers": ("tiles.scraper",),
    "thumbnail_size": tiles.SIZE,
    "download_all_examples": False,
    "show_memory": False,
    "write_computation_times": False,
    "remove_config_comments": True,
    "reference_url": {"skpose": None},
    "min_reported_time": 1,
    "subsection_order": [
        f"../examples/{section}"
        for section in ("distances", "recognition", "maps_and_clusters", "motions", "statistics", "people_and_robots")
    ],
    "within_subsection_order": "ExampleTitleSortKey",
    "abort_on_example_error": True,
}

for name in ("SKPOSE_CMU", "SKPOSE_HDM05", "SKPOSE_ROBOTS"):
    os.environ.pop(name, None)  # the same figures for everyone, from generated motions

# Warnings of packages; a warning of an example is an error in the tests.
warnings.filterwarnings("ignore", category=DeprecationWarning)


def skip_fields(app, what, name, value, skip, options):
    """Leave out the fields of named tuples, which their class describes."""
    return skip or (value.__doc__ or "").startswith("Alias for field number")


def setup(app):
    app.connect("autodoc-skip-member", skip_fields)
