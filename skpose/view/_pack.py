"""Arrays of numbers as text in a page: rounded to integers, small in number of characters.

Rows follow each other in time, so that the difference from row to row is small: its high bytes are nearly all equal,
and deflate removes them. `unpack` in assets/page.js is the counterpart of `unpack` here.
"""

import base64
import zlib
from typing import Any

import numpy as np

LEVELS = 2**16 - 1
MOST = 2**32 - 1
ANGLE = 2.0 * np.pi / 2**16  # rad, the step of angles

Packed = dict[str, Any]


def pack(values: np.ndarray, step: float | None = None) -> Packed:
    """Pack an array (n, k) of finite numbers as a JSON object; each is rounded to the nearest multiple of a step.

    Parameters
    ----------
    values : ndarray of shape (n, k)
        At least one number.
    step : float, default=None
        The step; None divides the range of all values into 65,535, so that no number is off by more than a 131,070th
        of the range. A given step takes 16 or 32 bits a number, and is made larger if 32 do not suffice.
    """
    low, extent = float(values.min()), float(np.ptp(values))
    dtype = np.dtype("<u2" if step is None or extent <= LEVELS * step else "<u4")
    step = extent / LEVELS if step is None else max(step, extent / MOST)
    steps = np.rint((values - low) / step) if step > 0.0 else np.zeros(values.shape)
    whole = steps.astype(dtype)
    change = np.diff(whole, axis=0, prepend=np.zeros((1, whole.shape[1]), dtype))  # modulo the number of levels
    bytes_of = np.ascontiguousarray(change.T).view(np.uint8).reshape(-1, dtype.itemsize)
    # Column by column, and of all numbers first the low bytes, then the next.
    text = base64.b64encode(zlib.compress(bytes_of.T.tobytes(), 9)).decode("ascii")
    return {"shape": list(values.shape), "low": low, "step": step, "bytes": dtype.itemsize, "data": text}


def unpack(packed: Packed) -> np.ndarray:
    """The array (n, k) that a page has after `pack`."""
    n, k = packed["shape"]
    content = zlib.decompress(base64.b64decode(packed["data"]))
    bytes_of = np.frombuffer(content, dtype=np.uint8).reshape(packed["bytes"], -1)
    change = np.ascontiguousarray(bytes_of.T).view(f"<u{packed['bytes']}").reshape(k, n)
    whole = np.cumsum(change, axis=1, dtype=change.dtype)
    return packed["low"] + packed["step"] * whole.T.astype(np.float64)
