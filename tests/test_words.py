"""The text of the project is plain English, and functions are verbs: words to avoid, checked in every file."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PATTERNS = [
    "skpose/**/*.py",
    "skpose/**/*.js",
    "skpose/**/*.html",
    "tests/**/*.py",
    "benchmarks/*",
    "examples/**/*",
    "docs/*.*",
    "docs/_extensions/**/*",
    "*.md",
    ".ci/run",
]
FILES = sorted({path for pattern in PATTERNS for path in ROOT.glob(pattern) if path.is_file()} - {Path(__file__)})
SOURCES = sorted((ROOT / "skpose").rglob("*.py"))

# Regular expressions of whole words, in any case; a blank matches a line break or an underscore too.
PLAIN = {
    "noughts?": "zero",
    "honest(y|ly)?": "that passes the discretisation check",
    "doubt(s|ful|fully)?": "unconverged",
    "cheat(s|ed|ing)?": "discretisation error",
    "heard": "interruptible",
    "(hangs?|hung|hanging) on": "is a child of, is attached to",
    "sets? out": "compute, start",
    "tellers?": "reporters",
    "tells|told": "report, return, state",
    "promising": "candidates",
    "pays": "is worth it",
    "parcels?": "payload",
    "kick(s|ed|ing)": "perturb",
    "(?<!Y_)screen(s|ed|ing)?": "filter",  # POINT:Y_SCREEN is a parameter of C3D files
    "(first|second|cheap|without a|one) look": "filter, lower bound",
    "blocks? of lanes|lanes? blocks?": "group of lanes",
    "(several|other|different|two|of) bodies|(a|one|mean|same) body|the body( that| on|\\.)": "skeleton",
    "joblib's engine": "backend",
    "turn(s|ed|ing)? about|unturned": "rotate, rotation",
    "way round|(short|shorter|shortest|straight|other|another|right|a long) ways?": "path; wrapped to [−π, π]",
    "ways(?! to| of| in)|the ways to": "paths",
    "by way of": "through",
    "under way": "in progress",
    "in the same way": "likewise",
    "(if|is|are) wanted|where (somebody|someone)|wants to know": "requested",
    "gone": "removed, missing",
    "begun": "started",
    "hence": "therefore",
    "thrice": "three times",
    "beside": "next to",
    "wherever": "where",
    "whatever": "every, any",
    "seldom|hardly": "rarely",
    "upon": "on",
    "alike": "equal",
    "all the same": "nevertheless",
    "as far as (it|they) (goes|go)": "(rewrite)",
    "to be had": "available",
    "so much": "(rewrite)",
    "(, |and )of which": "(rewrite)",
    "the house": "architecture",
}
# The same, in compiled code alone: see the glossary of `skpose._compiled`.
PLAIN_COMPILED = {
    "pieces?": "supernode",
    "tips?": "leaf",
    "separates?|separately": "by address",
    "runs of": "ranges of",
    "places": "indices, positions",
}
NOT_FIRST = {"What", "Where", "How", "Whether", "Of", "For", "As", "Those"}

# Words that end as participles do and are no participles, or are names of others and of the public interface.
VERBS = {"read", "embed", "need"}
PUBLIC = {"mirrored"}  # Motion.mirrored
NOUNS = {"shared"}  # a shared structure
PARTICIPLES = {
    "written",
    "drawn",
    "taken",
    "given",
    "chosen",
    "shown",
    "known",
    "seen",
    "found",
    "frozen",
    "hidden",
    "left",
}


def compiled(words):
    """Compile an expression: no letter before or after it, so that parts of `snake_case` names match too."""
    return re.compile(rf"(?<![^\W\d_])(?:{words})(?![^\W\d_])".replace(" ", r"[\s#_]+"), re.IGNORECASE)


def literals(words):
    """Return letters of which a text must have one that the expression matches: to look for them takes no time."""
    letters = re.findall(r"[^\W\d_]+", re.sub(r"\w\?", "", words))
    return letters if "|" in words else [max(letters, key=len)]


def expressions_of(table):
    return [(literals(words), compiled(words), replacement) for words, replacement in table.items()]


EXPRESSIONS, EXPRESSIONS_COMPILED = expressions_of(PLAIN), expressions_of(PLAIN_COMPILED)


def words_to_replace(text, name, expressions=EXPRESSIONS):
    """Return "file:line: word -> replacement" for each word of the table in a text."""
    lower = text.lower()
    found = sorted(
        (text.count("\n", 0, match.start()) + 1, re.sub(r"[\s#_]+", " ", match.group()), replacement)
        for some, expression, replacement in expressions
        if any(letters in lower for letters in some)
        for match in expression.finditer(text)
    )
    return [f"{name}:{line}: {words} -> {replacement}" for line, words, replacement in found]


def first_words_to_replace(source, name):
    """Return "file:line: word" for each docstring that begins with a word of `NOT_FIRST`."""
    nodes = [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
    ]
    docstrings = [(getattr(node, "lineno", 1), ast.get_docstring(node) or "") for node in nodes]
    return [
        f"{name}:{line}: a docstring begins with {words[0]} -> a verb or a noun"
        for line, text in docstrings
        if (words := re.findall(r"\w+", text)) and words[0] in NOT_FIRST
    ]


def participles(source, name):
    """Return "file:line: name" for each function, no property, whose name is a participle or begins with "checked"."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        first, *others = node.name.strip("_").split("_")
        is_participle = first in PARTICIPLES or (first.endswith("ed") and first not in VERBS | NOUNS | PUBLIC)
        is_property = any(ast.unparse(decorator).endswith("property") for decorator in node.decorator_list)
        if is_participle and not is_property and (not others or first == "checked"):
            found.append(f"{name}:{node.lineno}: {node.name} -> a verb")
    return found


def found_in(paths, search):
    """Return what `search` finds in all files."""
    return [line for path in paths for line in search(path.read_text(encoding="utf-8"), path.relative_to(ROOT))]


def test_words_are_plain():
    found = found_in(FILES, words_to_replace)
    assert not found, "\n" + "\n".join(found)


def test_words_of_compiled_code_are_those_of_the_field():
    paths = [path for path in SOURCES if "_compiled" in path.parts]
    found = found_in(paths, lambda text, name: words_to_replace(text, name, EXPRESSIONS_COMPILED))
    assert not found, "\n" + "\n".join(found)


def test_functions_are_verbs():
    found = found_in(SOURCES, participles)
    assert not found, "\n" + "\n".join(found)


def test_docstrings_begin_with_a_verb_or_a_noun():
    found = found_in(SOURCES, first_words_to_replace)
    assert not found, "\n" + "\n".join(found)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("a distance of nought", "f:1: nought -> zero"),
        ("\n# it goes the short\n# way round", "f:2: short way -> path"),
        ("self._parcel_size", "f:1: parcel -> payload"),
        ("WORTH = 1  # Whatever", "f:1: Whatever -> every, any"),
    ],
)
def test_a_word_of_the_table_is_found(text, found):
    assert any(line.startswith(found) for line in words_to_replace(text, "f"))


@pytest.mark.parametrize("text", ["the nearest neighbour", "offsets", "thoughts", "whence", "place a joint"])
def test_other_words_are_not_found(text):
    assert words_to_replace(text, "f") == []


@pytest.mark.parametrize(
    ("name", "found"),
    [("written", True), ("_checked_poses", True), ("_computed", True), ("read", False), ("weighted_mean", False)],
)
def test_a_function_that_is_a_participle_is_found(name, found):
    assert participles(f"class A:\n    def {name}(self):\n        pass\n", "f") == [f"f:2: {name} -> a verb"] * found
    assert participles(f"class A:\n    @property\n    def {name}(self):\n        pass\n", "f") == []


def test_a_docstring_that_begins_with_a_question_word_is_found():
    source = '"""A module."""\n\nclass A:\n    def _f(self):\n        """Whether it is so."""\n'
    assert first_words_to_replace(source, "f") == ["f:4: a docstring begins with Whether -> a verb or a noun"]
