"""What models write among the points of C3D files: no positions, and offered by name; ezc3d is a second opinion."""

import io
import struct

import c3d_files
import numpy as np
import pytest

from skpose.io import load_c3d, load_c3d_quantities

POSITIONS = np.random.default_rng(3).uniform(-800, 800, (20, 8, 3))
LABELS = ["hip", "LHipAngles", "knee", "LKneeForce", "ankle", "LKneePower", "Mass", "LHipMoment"]
KINDS = {
    "ANGLES": ["LHipAngles", "of no point"],
    "FORCES": ["LKneeForce"],
    "POWERS": ["LKneePower"],
    "SCALARS": ["Mass"],
    "MOMENTS": ["LHipMoment"],
    "ANGLE_UNITS": "deg",
    "MOMENT_UNITS": "Nmm",
    "MODELED_MARKERS": ["knee"],
}


def written(**options):
    options = {"axis_up": "+Z"} | KINDS | options
    return c3d_files.c3d_file(options.pop("positions", POSITIONS), options.pop("labels", LABELS), **options)


def test_they_are_no_positions():
    with pytest.warns(UserWarning, match="5 of 8 points are not positions"):
        markers = load_c3d(io.BytesIO(written()))
    assert markers.names == ("hip", "knee", "ankle")
    np.testing.assert_allclose(markers.positions, POSITIONS[:, [0, 2, 4]] / 1000, rtol=1e-6)


def test_they_are_offered_by_name_in_their_own_units():
    found = load_c3d_quantities(io.BytesIO(written()))
    assert [(name, one.kind, one.unit) for name, one in found.items()] == [
        ("LHipAngles", "angles", "deg"),
        ("LKneeForce", "forces", ""),
        ("LKneePower", "powers", ""),
        ("Mass", "scalars", ""),
        ("LHipMoment", "moments", "Nmm"),
    ]
    for name, one in found.items():
        np.testing.assert_allclose(one.values, POSITIONS[:, LABELS.index(name)], rtol=1e-6)


# What each label is: one of a model's, by its name alone, or the position of a marker.
BY_NAME = {
    "RHipMoment": "moments", "LNormalisedGRF": "forces", "Bob:LHipAngles": "angles", "L_KNEE_ANGLE_X": "angles",
    "Force 2": "forces",
}  # fmt: skip


def only_labels(labels, **options):
    positions = np.random.default_rng(1).uniform(-800, 800, (4, len(labels), 3))
    return io.BytesIO(c3d_files.c3d_file(positions, list(labels), axis_up="+Z", **options))


def test_a_name_alone_says_what_no_group_lists():
    with pytest.warns(UserWarning, match="5 of 8 points"):
        markers = load_c3d(only_labels([*BY_NAME, "hip", "inferior angle", "triangle2"]))
    assert markers.names == ("hip", "inferior angle", "triangle2")
    found = load_c3d_quantities(only_labels(["hip", *BY_NAME], ANGLE_UNITS="deg"))
    assert {name: one.kind for name, one in found.items()} == BY_NAME
    assert found["Bob:LHipAngles"].unit == "deg"


@pytest.mark.parametrize(("label", "listed"), [("Bob:LKA", "LKA"), ("LKA", "Bob:LKA"), ("Bob:LKA", "BOB: LKA")])
def test_labels_are_the_same_in_any_case_and_without_the_subject(label, listed):
    data = only_labels(["hip", label], ANGLES=[listed, "other"])
    assert [(name, one.kind) for name, one in load_c3d_quantities(data).items()] == [(label, "angles")]


@pytest.mark.parametrize("listed", [True, False])
def test_groups_that_the_file_names(listed):
    """TYPE_GROUPS has pairs, as Nexus writes them: the group, and its singular, by which its unit is called."""
    groups = ["REACTIONS", "REACTION", "MODELED_MARKERS", "MODELED_MARKER", "STRESSES", "STRESS", "NONE", "RATE"]
    more = {"TYPE_GROUPS": groups} if listed else {}
    data = only_labels(
        ["hip", "LGR", "knee", "S1"],
        REACTIONS=["LGR"],
        REACTION_UNITS="N",
        STRESSES=["S1"],
        MODELED_MARKERS=["knee"],
        **more,
    )
    found = {name: (one.kind, one.unit) for name, one in load_c3d_quantities(data).items()}
    assert found == {"LGR": ("reactions", "N")} | ({"S1": ("stresses", "")} if listed else {})


@pytest.mark.parametrize("processor", [c3d_files.INTEL, c3d_files.DEC, c3d_files.MIPS])
def test_events_have_times_since_the_first_frame(processor):
    """Times are minutes and seconds since the recording began, of which the file has the frames from 101 on."""
    order = ">" if processor == c3d_files.MIPS else "<"
    times = np.array([[0.0, 1.5], [1.0, 2.0], [0.0, 1.75]])
    group = struct.pack("2b", 5, -3) + b"EVENT" + struct.pack(order + "H", 3) + b"\0"
    values = {"CONTEXTS": ["Left", "Left", "Right"], "LABELS": ["Foot Strike", "Foot Strike", "Foot Off"]}
    more = [c3d_files.parameter(3, name, value, processor) for name, value in values.items()]
    more.append(c3d_files.parameter(3, "TIMES", times, processor, shape=(2, 3)))
    data = written(more=[group, *more], processor=processor)
    found = load_c3d_quantities(io.BytesIO(c3d_files.with_header(data, processor, first=101, last=120)))
    events = {name: one for name, one in found.items() if one.kind == "events"}
    assert list(events) == ["Left Foot Strike", "Right Foot Off"]
    np.testing.assert_allclose(events["Left Foot Strike"].values, [0.5, 61.0])
    np.testing.assert_allclose(events["Right Foot Off"].values, [0.75])
