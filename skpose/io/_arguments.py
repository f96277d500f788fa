"""Types of the arguments that readers and writers share."""

import os
from typing import IO

PathLike = str | os.PathLike
Readable = PathLike | IO
