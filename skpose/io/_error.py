"""The error of all readers."""

from pathlib import Path

from skpose.io._arguments import PathLike


class MocapFormatError(ValueError):
    """A motion-capture file that does not follow its format.

    Attributes
    ----------
    filename : str
        The file.
    line : int or None
        Number of the line, from 1; None if the fault is not in one line.
    column : int or None
        Number of the character in the line, from 1; None if the fault is the whole line.
    message : str
        What was expected, what was found, and what to do, without the position.

    Examples
    --------
    >>> import io
    >>> from skpose.io import MocapFormatError, load_bvh
    >>> try:
    ...     load_bvh(io.StringIO("HIERARCHY hello"))
    ... except MocapFormatError as error:
    ...     print(error.line, error.column, error.message)
    1 11 expected ROOT, found 'hello'
    """

    def __init__(self, filename: PathLike, line: int | None, message: str, column: int | None = None):
        self.filename, self.line, self.message, self.column = str(filename), line, message, column
        position = Path(self.filename).name
        position += f", line {line}" if line is not None else ""
        position += f", column {column}" if column is not None else ""
        super().__init__(f"{position}: {message}")

    def __reduce__(self) -> tuple:
        return MocapFormatError, (self.filename, self.line, self.message, self.column)
