"""Subjects, actions and trials of files: those of an index.csv, or of their names."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from skpose.datasets._shared import INDEX, NAME, WALKING_AND_RUNNING, rows_of

LABELS = re.compile(r"(?P<subject>[^_]+)_(?P<action>.+)_(?P<trial>[^_]+)\.bvh(\.gz)?", re.IGNORECASE)
CMU = re.compile(r"(?P<subject>\d+)_(?P<trial>\d+)(?P<action>)\.amc(\.gz)?", re.IGNORECASE)


class Labels(NamedTuple):
    """Labels of files, empty where they are not known."""

    subjects: list[str]
    trials: list[str]
    actions: list[str]


def labels_of(files: Sequence[Path]) -> Labels:
    """Return the labels of files, by an index.csv in the folder of each or in one above it, or by their names."""
    indexed = rows_of(files)
    found = []
    for path in files:
        matches = (pattern.fullmatch(path.name) for pattern in (LABELS, NAME, CMU))
        named = next(filter(None, matches), None)
        words = {} if named is None else {key: text.replace("_", " ") for key, text in named.groupdict("").items()}
        found.append(indexed.get(path, words))
    subjects, trials, actions = ([row.get(key, "") for row in found] for key in ("subject", "trial", "action"))
    return Labels(subjects, trials, actions)


def labels_in_names(folder: Path, paths: Sequence[Path], *, gait: bool) -> dict[str, list[str]]:
    """Return subjects, actions and trials from the names of BVH files; of `gait`, some of which walk and some run."""
    action = ", where ACTION begins with the word walk or run in some of them" if gait else ""
    expected = f"SUBJECT_ACTION_TRIAL.bvh{action}, such as anna_walk_1.bvh, anna_run_2.bvh, ben_walk_fast_1.bvh"
    if not paths:
        raise FileNotFoundError(
            f"{folder} holds neither an {INDEX}, see skpose.datasets.load_cmu, nor BVH files named {expected}"
        )
    found = [LABELS.fullmatch(path.name) for path in paths]
    if None in found:
        raise ValueError(f"{paths[found.index(None)]} has no labels in its name: expected {expected}")
    labels = {key: [match[key].replace("_", " ") for match in found if match] for key in ("subject", "action", "trial")}
    for word in WALKING_AND_RUNNING if gait else ():
        if not any(re.split(r"\W", action.lower())[0] == word for action in labels["action"]):
            raise ValueError(
                f"{folder} has no file whose action is {word!r}, but {', '.join(sorted(set(labels['action']))[:8])}: "
                f"expected names like {expected}"
            )
    return labels
