"""Is this motion any good? Checks of motions and of collections of them.

| module | |
|---|---|
| `_findings` | findings, the registry of checks, and their thresholds |
| `_frames` | faults in time: missing, repeated, interpolated frames, jumps, noise, angles |
| `_body` | faults of the body in the world: units, axes, frame rate, floor, feet, knees, sides |
| `_collection` | duplicates, mixtures, motions unlike the others |
| `_check` | the function that runs them all; `_report` is the page that plays the findings |
"""

from skpose.checks._check import check_motion

__all__ = ["check_motion"]
