"""Motion-capture files with errors in them, for the fuzz test and the fuzz benchmark."""

import io
import warnings
from collections.abc import Sequence
from pathlib import Path

from hypothesis import strategies as st

from skpose import Motion, Skeleton
from skpose.io import MocapFormatError, load_amc, load_asf, load_bvh, load_motion

DATA = Path(__file__).parent / "data"
BVH, ASF, AMC = ((DATA / name).read_bytes() for name in ("biped.bvh", "arm.asf", "arm.amc"))
VALID = {"BVH": BVH, "ASF": ASF, "AMC": AMC}

NASTY = [
    b"", b"0", b"-1", b"1e999", b"-1e308", b"1e-320", b"nan", b"-inf", b"1.#IND", b"1,5", b"0.0-7.5", b"1_0", b"0x10",
    b"999999999", b"9999999999999999999", b"9" * 5000, b"{", b"}", b"{" * 2000, b"}" * 2000, b"(", b")", b"#", b":",
    b"::", b":root", b":bonedata", b"begin", b"end", b"HIERARCHY", b"ROOT", b"JOINT", b"End Site", b"MOTION", b"OFFSET",
    b"CHANNELS", b"CHANNELS 999999999", b"CHANNELS 0", b"Frames:", b"Frames: 1000000000", b"Frame Time:", b"Xrotation",
    b"Xposition", b"root", b"upperarm", b"Hips", b"dof", b"limits", b"axis", b"XYZ", b"\0", b"\xff\xfe",
    b"\xef\xbb\xbf", b"\r", b"\n", b"\x1c", b"\xc2\xa0", b"\xd9\xa3", b"__import__('os').abort()",
    b"\x80\x04cos\nabort\n(tR.",
]  # fmt: skip
NEST = {
    "BVH": (b"JOINT a%d\n{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\n", b"}\n"),
    "ASF": (b"begin\nname b%d\ndirection 0 1 0\nlength 1\naxis 0 0 0 XYZ\n", b"end\n"),
    "AMC": (b"%d\n", b""),
}


@st.composite
def files(draw, kinds: Sequence[str] = ("BVH", "BVH", "ASF", "AMC"), n_most: int = 4):
    """Draw (kind, bytes): a valid file of one of these kinds with up to a few mutations, or random bytes."""
    kind = draw(st.sampled_from(kinds))
    data = VALID[kind]
    if draw(st.integers(0, 30)) == 0:
        return kind, draw(st.binary(max_size=2000))
    for _ in range(draw(st.integers(1, n_most))):
        data = draw(st.sampled_from(MUTATIONS))(draw, data, kind)
    return kind, data


def _cut(draw, data, kind):
    start, stop = sorted(draw(st.tuples(*[st.integers(0, len(data))] * 2)))
    return draw(st.sampled_from([data[:stop], data[start:], data[:start] + data[stop:]]))


def _parts(separator: bytes):
    """Return a maker of mutations of the file's words or lines, without changes to their separators."""

    def of(change):
        def mutation(draw, data, kind):
            parts = data.split(separator)
            i, j = draw(st.tuples(*[st.integers(0, len(parts) - 1)] * 2))
            change(draw, parts, i, j)
            return separator.join(parts)

        return mutation

    return of


_words, _lines = _parts(b" "), _parts(b"\n")


def _swap(draw, parts, i, j):
    parts[i], parts[j] = parts[j], parts[i]


def _duplicate(draw, parts, i, j):
    parts.insert(j, parts[i])


def _many(draw, parts, i, j):
    parts[i:i] = [parts[i]] * draw(st.sampled_from([10, 1000]))


def _drop(draw, parts, i, j):
    del parts[i]


def _replace(draw, parts, i, j):
    parts[i] = draw(st.sampled_from(NASTY) | st.binary(max_size=8))


def _bytes(draw, data, kind):
    at = draw(st.integers(0, len(data)))
    return data[:at] + draw(st.binary(min_size=1, max_size=4)) + data[at + draw(st.integers(0, 2)) :]


def _claim(draw, data, kind):
    """State counts that are far larger than the file."""
    count = str(draw(st.sampled_from([0, 1, 10**6, 10**9, 10**18, 10**30]))).encode()
    old, new = draw(st.sampled_from([(b"Frames: 2", b"Frames: "), (b"CHANNELS 3", b"CHANNELS ")]))
    return data.replace(old, new + count)


def _nest(draw, data, kind):
    """Nest blocks of the format, some left open."""
    opening, closing = NEST[kind]
    depth = draw(st.sampled_from([1, 3, 30, 100, 1000, 10_000]))
    closed = draw(st.sampled_from([0, 1, depth, depth + 1]))
    lines = data.split(b"\n")
    at = draw(st.integers(0, len(lines)))
    nested = b"".join(opening % i for i in range(depth)) + closing * closed
    return b"\n".join(lines[:at]) + b"\n" + nested + b"\n".join(lines[at:])


MUTATIONS = [
    _cut, _bytes, _claim, _nest, *(_words(change) for change in (_swap, _duplicate, _drop, _replace, _replace)),
    *(_lines(change) for change in (_swap, _duplicate, _drop, _many)),
]  # fmt: skip

options = st.fixed_dictionaries(
    {
        "on_nan": st.sampled_from(["raise", "drop"]),
        "trust": st.sampled_from(["header", "rows"]),
        "stretch": st.sampled_from(["raise", "mean"]),
        "missing": st.sampled_from(["raise", "rest"]),
        "root": st.sampled_from([None, None, "Hips", "Chest", "x"]),
    }
)


def outcome(kind: str, data: bytes, chosen: dict[str, str]) -> str:
    """Return "read" or "refused" for a file; any exception but MocapFormatError is raised."""

    def some(*names):
        return {name: chosen[name] for name in names}

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message="the open file: ", category=UserWarning)
        try:
            if kind == "BVH":
                made = [load_bvh(io.BytesIO(data), **some("on_nan", "trust", "stretch", "root"))]
            elif kind == "ASF":
                made = [
                    load_asf(io.BytesIO(data)),
                    load_amc(io.BytesIO(AMC), io.BytesIO(data), frame_rate=60, **some("missing")),
                ]
            else:
                chosen = chosen | {"root": None}  # which AMC does not have
                made = [load_amc(io.BytesIO(data), io.BytesIO(ASF), frame_rate=60, **some("on_nan", "missing"))]
            made.append(
                load_motion(io.BytesIO(data), asf=io.BytesIO(ASF), frame_rate=60, **chosen)
                if kind != "ASF"
                else made[-1]
            )
        except MocapFormatError as error:
            if not error.message or not str(error).startswith("the open file"):
                raise AssertionError(f"an error without message or file name: {error!r}") from error
            return "refused"
    if not all(isinstance(one, Motion | Skeleton) for one in made):
        raise AssertionError(f"neither a motion nor a skeleton: {made!r}")
    return "read"
