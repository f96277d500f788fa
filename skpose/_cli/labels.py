"""Subjects, actions, trials and frame rates of files, by an index.csv or by their names."""

import re
from collections.abc import Sequence
from pathlib import Path

from skpose.datasets._hdm05 import NAME
from skpose.datasets._index import rows_of

BVH = re.compile(r"(?P<subject>[^_]+)_(?P<action>.+)_(?P<trial>[^_]+)\.bvh(\.gz)?", re.IGNORECASE)
CMU = re.compile(r"(?P<subject>\d+)_(?P<trial>\d+)(?P<action>)\.amc(\.gz)?", re.IGNORECASE)


def stated_rates(files: Sequence[Path]) -> dict[Path, float]:
    """The frame rates, Hz, of AMC files, which do not state theirs."""
    files = [path for path in files if path.name.lower().removesuffix(".gz").endswith(".amc")]
    named = {path: float(match["rate"]) for path in files if (match := NAME.fullmatch(path.name))}
    indexed = {path: row["frames_per_second"] for path, row in rows_of(files).items()}
    return named | {path: rate for path, rate in indexed.items() if rate is not None}


def labels_of(files: Sequence[Path]) -> dict[str, list[str]]:
    """The subjects, actions and trials of files, "" where unknown; kinds of labels that no file has are left out."""
    indexed, rows = rows_of(files), []
    for path in files:
        match = next(filter(None, (pattern.fullmatch(path.name) for pattern in (BVH, NAME, CMU))), None)
        named = {} if match is None else {key: text.replace("_", " ") for key, text in match.groupdict("").items()}
        rows.append(indexed.get(path, named))
    labels = {f"{key}s": [row.get(key, "") for row in rows] for key in ("subject", "action", "trial")}
    return {name: values for name, values in labels.items() if any(values)}
