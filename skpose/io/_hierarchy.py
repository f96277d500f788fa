"""The first part of a BVH file, word by word: its joints, and the meaning of the numbers that follow."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import cast

from skpose.io._source import Chunk, Source
from skpose.io._words import WHOLE, Token

WORD = re.compile(r"[{}]|[^\s{}]+", re.ASCII)
WORD_OR_COLON = re.compile(r"[^\s:]+", re.ASCII)  # after MOTION, as "Frames:12" and "Frames : 12" mean the same
NAME = re.compile(r"[^{}\r\n]*")
CHANNELS = {f"{axis}{kind}" for axis in "xyz" for kind in ("position", "rotation")}


@dataclass(eq=False)
class Joint:
    """One block of the hierarchy."""

    name: str  # empty for an End Site
    parent: "Joint | None"
    opened: Token  # its ROOT, JOINT or End
    offset: list[float] = field(default_factory=list)
    channels: list[str] = field(default_factory=list)  # such as "xposition", "zrotation"
    first: int = 0  # index of its first number in a frame
    given: set[str] = field(default_factory=set)  # OFFSET, CHANNELS: the statements that are read

    def columns(self, kind: str) -> dict[str, int]:
        """Return the axes of its channels of a kind, in the file's order, and their indices in a frame."""
        return {channel[0]: self.first + k for k, channel in enumerate(self.channels) if channel.endswith(kind)}

    def __str__(self) -> str:
        return repr(self.name) if self.name else f"the End Site of {self.parent}"


class Lexer:
    """The words of a source, one after another."""

    def __init__(self, source: Source):
        self.source = source
        self._text, self._at = "", 0

    def next(self, pattern: re.Pattern = WORD) -> Token | None:
        """Return the next word, or None at the end of the file."""
        while not (match := pattern.search(self._text, self._at)):
            text = self.source.readline()
            if text is None:
                return None
            self._text, self._at = text, 0
        self._at = match.end()
        return Token(match[0], self.source.line, match.start() + 1)

    def expect(self, what: str, pattern: re.Pattern = WORD) -> Token:
        """Return the next word; the end of the file is an error."""
        token = self.next(pattern)
        if token is None:
            raise self.source.error(f"expected {what}, found the end of the file; is it cut short?", self.source.line)
        return token

    def name(self) -> str:
        """Return the rest of the line, up to a brace: names may have blanks in them."""
        match = cast(re.Match, NAME.match(self._text, self._at))  # at least the empty string matches
        self._at = match.end()
        return match[0].strip()

    def rest(self) -> Iterator[Chunk]:
        """Yield all lines that have not been read."""
        if text := self._text[self._at :]:
            yield Chunk(self.source.line, self._at, text.encode())
        yield from self.source.chunks()


def read_hierarchy(lexer: Lexer) -> list[Joint]:
    """Return the joints in the order of the file, the root first, up to the word MOTION."""
    source = lexer.source
    first = lexer.expect("HIERARCHY")
    if first.upper() != "HIERARCHY":
        raise source.error(f"expected HIERARCHY, found {str(first[:40])!r}; not a BVH file?", first)
    joints: list[Joint] = []
    joint: Joint | None = None  # the block that is open
    while (word := lexer.next()) is not None:
        keyword = word.upper()
        if keyword in ("ROOT", "JOINT", "END"):
            joint = _open(lexer, word, joint, joints)
        elif joint is not None and keyword == "OFFSET":
            _once(joint, word, source)
            joint.offset = [source.number(lexer.expect("3 numbers"), f"OFFSET of {joint}") for _ in range(3)]
        elif joint is not None and keyword == "CHANNELS":
            _once(joint, word, source)
            joint.channels = _channels(lexer, joint)
        elif joint is not None and word == "}":
            if "OFFSET" not in joint.given:
                raise source.error(f"{joint}, which begins in line {joint.opened.line}, has no OFFSET", word)
            joint = joint.parent
        elif joint is not None:
            raise source.error(
                f"expected OFFSET, CHANNELS, JOINT, End Site or }} in {joint}, found {str(word[:40])!r}", word
            )
        elif keyword == "MOTION" and joints:
            n_numbers = 0
            for one in joints:
                one.first = n_numbers
                n_numbers += len(one.channels)
            return joints
        else:
            raise source.error(f"expected {'MOTION' if joints else 'ROOT'}, found {str(word[:40])!r}", word)
    problem = f"{joint}, which begins in line {joint.opened.line}, is still open" if joint else "there is no MOTION"
    raise source.error(f"the file ends and {problem}; not BVH, or cut short", source.line)


def _open(lexer: Lexer, word: Token, parent: Joint | None, joints: list[Joint]) -> Joint:
    """Return the block that a keyword begins, read up to its brace."""
    source, keyword = lexer.source, word.upper()
    if keyword == "ROOT" and (parent or joints):
        raise source.error("found a second ROOT; expected one skeleton in a file: split it", word)
    if keyword != "ROOT" and parent is None:
        raise source.error(f"found {word} outside a joint", word)
    name = lexer.name()
    brace = lexer.expect("{")
    if keyword == "END":
        name = ""
        if brace.upper() == "SITE":
            brace = lexer.expect("{")
    elif not name:
        raise source.error(f"expected a name after {word}, found none", word)
    if brace != "{":
        raise source.error(f"expected {{ after {name or 'End Site'!r}, found {str(brace[:40])!r}", brace)
    joint = Joint(name, parent, word)
    joints.append(joint)
    return joint


def _once(joint: Joint, word: Token, source: Source) -> None:
    """Raise an error unless this is the first statement of its kind in the block."""
    if word.upper() in joint.given:
        raise source.error(f"{joint} has {word} twice", word)
    joint.given.add(word.upper())


def _channels(lexer: Lexer, joint: Joint) -> list[str]:
    source, what = lexer.source, f"CHANNELS of {joint}"
    count = lexer.expect("a number")
    if not WHOLE.fullmatch(count):
        raise source.error(f"{what}: expected how many there are, found {str(count[:40])!r}", count)
    channels: list[str] = []
    while len(channels) < int(count):  # at most seven times, as a seventh channel is an error
        word = lexer.expect("a channel")
        channel = word.lower()
        if channel not in CHANNELS or channel in channels:
            raise source.error(
                f"{what}: expected {count} of Xposition … Zrotation, each once, found {str(word[:40])!r}", word
            )
        channels.append(channel)
    return channels


def read_motion_head(lexer: Lexer) -> tuple[Token, Token]:
    """Return the number of frames that the file states, and the duration of each, as words."""
    source = lexer.source
    n_frames = frame_time = None
    while n_frames is None or frame_time is None:
        missing = "Frames:" if n_frames is None else "Frame Time:"
        word = lexer.expect(missing, WORD_OR_COLON)
        key = word.lower()
        if key == "frame":
            key += " " + lexer.expect("Time:", WORD_OR_COLON).lower()
        if key == "frames" and n_frames is None:
            n_frames = lexer.expect("how many frames", WORD_OR_COLON)
            if not WHOLE.fullmatch(n_frames):
                raise source.error(f"Frames: expected a whole number, found {str(n_frames[:40])!r}", n_frames)
        elif key == "frame time" and frame_time is None:
            frame_time = lexer.expect("a number of seconds", WORD_OR_COLON)
        else:
            raise source.error(f"expected {missing} after MOTION, found {str(word[:40])!r}", word)
    return n_frames, frame_time
