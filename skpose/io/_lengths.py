"""Units of length that files name."""

METRES = {
    "m": 1.0, "meter": 1.0, "metre": 1.0, "meters": 1.0, "metres": 1.0,
    "cm": 0.01, "centimeter": 0.01, "centimetre": 0.01, "centimeters": 0.01, "centimetres": 0.01,
    "mm": 0.001, "millimeter": 0.001, "millimetre": 0.001, "millimeters": 0.001, "millimetres": 0.001,
    "in": 0.0254, "inch": 0.0254, "inches": 0.0254,
    "ft": 0.3048, "foot": 0.3048, "feet": 0.3048,
}  # fmt: skip


ANGLES = {"rad", "rads", "radian", "radians", "deg", "degs", "degree", "degrees", "°"}
FEWEST = 4  # letters of a name that is cut short, as where a C3D file has no room for more


def metres_of(unit: str) -> float | None:
    """Return the metres of one unit, by its name in any case, also where its end is cut off; None if not known."""
    word = unit.strip().lower()
    if word in METRES or len(word) < FEWEST:
        return METRES.get(word)
    found = {metres for name, metres in METRES.items() if name.startswith(word)}
    return found.pop() if len(found) == 1 else None


def is_angle(unit: str) -> bool:
    """Return whether a unit is one of angles, by its name in any case, also where its end is cut off."""
    word = unit.strip().lower()
    return word in ANGLES or (len(word) >= FEWEST and any(name.startswith(word) for name in ANGLES))


def complaint_of_unit(where: str, unit: str) -> str:
    """Return the message on a unit that is not known, and `where` the file states it."""
    if is_angle(unit):
        return f"{where}: expected a unit of length, found {unit[:40]!r}: these are angles, no positions of markers"
    return (
        f"{where}: expected a unit of length such as mm, cm, m, in or ft, found {unit[:40]!r}; scale=, the metres of "
        "one unit, reads the file nevertheless"
    )
