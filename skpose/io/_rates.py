"""Frame rates that files state, and those that a caller states in their place."""

from skpose.io._source import Source

SAME = 0.01  # relative difference of two rates that are one, rounded
SLOWEST, FASTEST = 2.0, 2000.0  # Hz; recordings of people are between these
LIKELY = 10.0, 500.0  # Hz, of another reading of a number


def choose_rate(source: Source, given: float | None, stated: float, where: str) -> float:
    """Return the frame rate, Hz: the one that is given, with a warning where the file states another, or the file's."""
    if given is None:
        return stated
    if SLOWEST <= stated <= FASTEST and differ(given, stated):
        source.warn(
            f"frame_rate={given:g} replaces the {stated:g} Hz of {where}, so that it lasts {stated / given:.3g} times "
            "as long; resample changes the rate of what has been read"
        )
    return given


def differ(one: float, other: float) -> bool:
    """Return whether two rates, Hz, are more than rounding apart."""
    return abs(one - other) > SAME * other


def complaint_of_frame_time(seconds: float) -> str:
    """Return what speaks against the duration of a frame, and the rates that may be meant; empty if nothing does."""
    rate = 1.0 / seconds
    if SLOWEST <= rate <= FASTEST:
        return ""
    if rate < SLOWEST:
        readings = {"in milliseconds": 1000.0 / seconds, "the number of frames a second": seconds}
    else:
        readings = {"a thousandth of what is meant": rate / 1000.0}
    likely = [
        f"if it is {what}, the rate is {hertz:.6g} Hz, frame_rate={hertz:.4g}"
        for what, hertz in readings.items()
        if LIKELY[0] <= hertz <= LIKELY[1]
    ]
    remedy = "; ".join(likely) or "frame_rate= chooses the rate where it is not that of the recording"
    return f"Frame Time is {seconds:.6g} s, which is {rate:.3g} frames a second: {remedy}"
