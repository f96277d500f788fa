"""What models write among the points of C3D files: no positions, and offered by name; ezc3d is a second opinion."""

import io

import c3d_files
import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, load_c3d, load_c3d_quantities

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
    with pytest.warns(
        UserWarning,
        match="5 of 8 points are no positions of markers and are left out: 1 in POINT:ANGLES, 1 in POINT:FORCES, "
        "1 in POINT:MOMENTS, 1 in POINT:POWERS, 1 in POINT:SCALARS; load_c3d_quantities reads them by their names",
    ):
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


def test_lists_that_go_on_in_another_parameter():
    names = [f"m{i}Angles" for i in range(255)] + ["LHipAngles"]
    data = written(ANGLES=names[:255], ANGLES2=names[255:])
    assert "LHipAngles" in load_c3d_quantities(io.BytesIO(data))


def test_where_a_frame_has_none_values_are_nan():
    positions = POSITIONS.copy()
    positions[4, 1] = np.nan
    values = load_c3d_quantities(io.BytesIO(written(positions=positions)))["LHipAngles"].values
    np.testing.assert_array_equal(np.isnan(values).all(axis=1), np.arange(20) == 4)


def test_a_file_without_positions():
    data = written(ANGLES=LABELS, FORCES=None, POWERS=None, SCALARS=None, MOMENTS=None)
    with pytest.raises(
        MocapFormatError, match="none of its points is a position of a marker: 8 in POINT:ANGLES, which"
    ):
        load_c3d(io.BytesIO(data))
    assert len(load_c3d_quantities(io.BytesIO(data))) == 8


def test_a_file_of_markers_alone():
    assert load_c3d_quantities(io.BytesIO(c3d_files.c3d_file(damaged.positions(), damaged.NAMES))) == {}
    with pytest.raises(MocapFormatError, match="expected a C3D file"):
        load_c3d_quantities(io.BytesIO(b"hello"))


@pytest.mark.filterwarnings("ignore:.*5 of 8 points are no positions:UserWarning")
def test_ezc3d_reads_the_same_numbers(tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    (tmp_path / "a.c3d").write_bytes(written())
    file = ezc3d.c3d(str(tmp_path / "a.c3d"))
    labels = file["parameters"]["POINT"]["LABELS"]["value"]
    points = {label: file["data"]["points"][:3, i].T for i, label in enumerate(labels)}
    quantities, markers = load_c3d_quantities(tmp_path / "a.c3d"), load_c3d(tmp_path / "a.c3d")
    assert {*quantities, *markers.names} == set(points)
    for name, one in quantities.items():
        np.testing.assert_array_equal(one.values, points[name])
    for i, name in enumerate(markers.names):
        np.testing.assert_array_equal(markers.positions[:, i], points[name] * 0.001)
