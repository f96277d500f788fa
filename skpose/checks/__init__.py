"""Is this motion any good? Checks of motions and of collections of them.

| module | |
|---|---|
| `_findings` | findings, and the table of their kinds with all thresholds |
| `_measures` | the size of each kind of fault at each frame of a `_recording` |
| `_collection` | duplicates, mixtures, motions unlike the others |
| `_check` | the function that does all of it; `_report` is the page that plays the findings |
"""

from skpose.checks._check import check_motion

__all__ = ["check_motion"]
