"""Where the chunks of a file end changes nothing: the same motions to the last bit, the same errors to the column."""

import io
import random
import warnings

import mutations
import pytest
from conftest import DATA

from skpose.io import MocapFormatError, _source, load_amc, load_bvh, load_motion

ASF = DATA / "arm.asf"
BLANKS = [
    b"",
    b" ",
    b"\n",
    b"\t",
    b"\r",
    b"\r\n",
    b"\v",
    b"\f",
    b"\x1c",
    b"\x85",
    b"\xc2\xa0",
    b"\n\n",
    b"\xef\xbb\xbf",
]
WORDS = [b"0", b"9", b".", b"-", b"+", b"e", b"_", b"#", b":", b"nan", b"inf", b"1e-300", b"1e400", b"1e23", b"0e999",
         b"9007199254740993", b"1" * 30, b"0.1234567890123456789", b"1,5", b"1e", b".5", b"5.", b"\0", b"\xff",
         b"# a comment\n", b"7\n", b"12\n", b"root", b"tip 1\n", b"1_0"]  # fmt: skip
FORMS = ["%.6f", "%g", "%.17g", "%.20g", "%.3e", "%d"]


def amc_file(rng):
    """Return an AMC file of several frames: the head and the bones of a small one, with other numbers."""
    head, _, rest = mutations.AMC.partition(b"\n1\n")
    lines = rest.partition(b"\n2\n")[0].splitlines()
    text, first = [head, b"\n"], rng.randrange(3)
    for k in range(rng.choice([1, 2, 9])):
        text.append(b"%d\n" % (first + k))
        for line in lines:
            name, *numbers = line.split()
            text += [name, *(b" " + written(rng, rng.choice(FORMS)) for _ in numbers)]
            text.append(rng.choice([b"\n", b"\n", b"\r\n", b" \n"]))
    return b"".join(text)


def bvh_file(rng):
    head, _, rest = mutations.BVH.partition(b"Frames: 2")
    frame_time, row = rest.lstrip(b"\r\n").split(b"\n")[:2]
    n_frames, form = rng.choice([1, 2, 9]), rng.choice(FORMS)
    rows = [b" ".join(written(rng, form) for _ in row.split()) for _ in range(n_frames)]
    return b"".join([head, b"Frames: %d\n" % n_frames, frame_time, b"\n", *(row + b"\n" for row in rows)])


def written(rng, form):
    return (form % rng.gauss(0, 50)).encode()


def changed(rng, data):
    """Return a file with a few changes, or none."""
    for _ in range(rng.choice([0, 1, 1, 1, 2, 3])):
        separator = rng.choice([None, None, b"\n", b" "])
        if separator is None:
            at = rng.randrange(len(data) + 1)
            data = data[:at] + rng.choice(BLANKS + WORDS) + data[at + rng.choice([0, 0, 1, 2]) :]
            continue
        parts = data.split(separator)
        i, j = rng.randrange(len(parts)), rng.randrange(len(parts))
        match rng.randrange(4):
            case 0:
                parts[i], parts[j] = parts[j], parts[i]
            case 1:
                parts.insert(j, parts[i])
            case 2:
                del parts[i]
            case 3:
                parts[i] = rng.choice(WORDS)
        data = separator.join(parts)
    return data


def outcome(read, file, *arguments, **options):
    """Return the bytes of all numbers of a motion and the warnings, or the error, of a file or of its content."""
    file = io.BytesIO(file) if isinstance(file, bytes) else file
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            motion = read(file, *arguments, **options)
        except MocapFormatError as error:
            return str(error), error.line, error.column
    arrays = (motion.angles, motion.root_positions, motion.root_angles, motion.frame_numbers)
    return [array.tobytes() for array in arrays], motion.skeleton, [str(warning.message) for warning in caught]


@pytest.fixture
def both(monkeypatch):
    """Return the outcome of a reader, the same in chunks of so many bytes and in usual ones."""

    def compare(chunk, *arguments, **options):
        usual = outcome(*arguments, **options)
        with monkeypatch.context() as patch:
            patch.setattr(_source, "CHUNK", chunk)
            assert outcome(*arguments, **options) == usual
        return usual

    return compare


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["AMC", "BVH"])
def test_changed_files(kind, seed, both):
    """A third is read."""
    rng, n_read = random.Random(seed), 0
    for _ in range(200):
        data = changed(rng, {"AMC": amc_file, "BVH": bvh_file}[kind](rng))
        chunk = rng.choice([1, 50, 300])
        on_nan, missing, trust = (
            rng.choice(choices) for choices in (["raise", "drop"], ["raise", "rest"], ["header", "rows"])
        )
        if kind == "AMC":
            found = both(chunk, load_amc, data, ASF, frame_rate=60, on_nan=on_nan, missing=missing)
        else:
            found = both(chunk, load_bvh, data, on_nan=on_nan, trust=trust)
        n_read += isinstance(found[0], list)
    assert 40 < n_read < 160


FRAMES = b"".join(b"%d\nroot 1 2 3 4 5 %d\nupperarm 1 2 3\nlowerarm 1 2.5\ntip %d\n" % (k, k, -k) for k in range(1, 40))
UNUSUAL = [
    (b"\ntip -20\n", b"\ntip nan\n"),
    (b"\ntip -20\n", b"\ntip 1e-300\n"),
    (b"\ntip -20\n", b"\ntip 1_0\n"),
    (b"\ntip -20\n", b"\ntip -20 # still\n\n"),
    (b"\ntip -20\n", b"\ntip -20 3\n"),
    (b"\ntip -20\n", b"\ntip -20 # 3\n"),
    (b"\ntip -20\n", b"\ntip\n-20\n"),
    (b"\ntip -20\n", b"\nTIP -20\n"),
    (b"\ntip -20\n", b"\nhand 1\n"),
    (b"\ntip -20\n", b"\n"),
    (b"\ntip -20\n", b"\ntip 1\ntip -20\n"),
    (b"\nroot 1 2 3 4 5 20\n", b"\nroot 1 2 3 4 5\n20\n"),
    (b"\nroot 1 2 3 4 5 20\n", b"\nroot 1 2 3 4 5\n-20\n"),
    (b"\nroot 1 2 3 4 5 20\n", b"\nroot 1 2 3 4 5\ntail\n"),
    (b"\n20\n", b"\n21\n"),
    (b"\n20\n", b"\n 20 \n"),
    (b"\n20\n", b"\n20 # twenty\n"),
    (b"\n20\n", b"\n\xd9\xa2\xd9\xa0\n"),
    (b"\n20\n", b"\n"),
    (b"\ntip -39\n", b"\ntip -39"),
    (b"\ntip -39\n", b"\ntip -"),
    (b"\ntip -39\n", b"\ntip -39\n\n\n# the end"),
    (b"\n", b"\r\n"),
    (b"\n", b"\n\n"),
    (b"upperarm 1 2 3\nlowerarm 1 2.5\n", b"lowerarm 1 2.5\nupperarm 1 2 3\n"),
]


@pytest.mark.parametrize(("old", "new"), UNUSUAL)
@pytest.mark.parametrize("missing", ["raise", "rest"])
def test_what_is_unusual_in_the_middle_of_a_file(old, new, missing, both):
    assert old in FRAMES
    data = b":DEGREES\n" + FRAMES.replace(old, new)
    both(40, load_amc, data, ASF, frame_rate=60, missing=missing, on_nan="drop")


@pytest.mark.slow
def test_real_files(cmu_folder, hdm05_folder, both):
    for path in [*cmu_folder.rglob("*.amc"), *hdm05_folder.rglob("*_01*.amc")]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = both(5000, load_motion, path, frame_rate=120)
        assert isinstance(found[0], list), path
