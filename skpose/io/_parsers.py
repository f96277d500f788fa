"""The compiled parsers, for those who read megabytes.

They are several times as fast as numpy's, but need numba, half a second to import and set up, and are compiled once on
each machine, for 0.6 to 0.9 s. A process that reads a few small files has no use for them.
"""

from types import ModuleType

FEW = 4_000_000  # bytes that a process reads without them, in 0.03 to 0.2 s


class Parsers:
    """The decision for compiled code, which falls once, after some megabytes."""

    def __init__(self) -> None:
        self.n_bytes = 0  # that this process has read

    def compiled(self, text: bytes) -> ModuleType | None:
        """Return `skpose._compiled.text` if this text, and all further ones, should be read by it."""
        self.n_bytes += len(text)
        if self.n_bytes <= FEW:
            return None
        from skpose._compiled import text as parsers

        return parsers if hasattr(parsers.decimals, "signatures") else None  # plain Python with NUMBA_DISABLE_JIT=1


PARSERS = Parsers()
