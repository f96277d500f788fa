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


# What each label is: one of a model's, by its name alone, or the position of a marker.
BY_NAME = {
    "LKneeAngles": "angles", "RHipMoment": "moments", "LAnklePower": "powers", "LGroundReactionForce": "forces",
    "LNormalisedGRF": "forces", "Bob:LHipAngles": "angles", "L_KNEE_ANGLE_X": "angles", "RAbsAnkleAngle": "angles",
    "Force 2": "forces", "KneeMoments_L": "moments", "lkneetorque": "moments",
}  # fmt: skip
MARKERS = [
    "LKNE", "Triangle1", "rectangle", "RInferiorAngle", "AngleInf", "SternalAngle", "scap_inf_angle", "L_ANKLE",
    "Forcep", "ForcePlate1", "CentreOfMass", "Bob:LANK", "RANG", "Moments of Bob's hand", "L.Tri.Angle.Top", "angles1a",
    "Powerhand",
]  # fmt: skip


def only_labels(labels, **options):
    positions = np.random.default_rng(1).uniform(-800, 800, (4, len(labels), 3))
    return io.BytesIO(c3d_files.c3d_file(positions, list(labels), axis_up="+Z", **options))


@pytest.mark.parametrize("label", BY_NAME)
def test_a_name_alone_says_what_no_group_lists(label):
    with pytest.warns(
        UserWarning,
        match=f"1 of 4 points are no positions of markers and are left out: 1 by name alone [(]{label}[)]; "
        "load_c3d_quantities reads them by their names",
    ):
        markers = load_c3d(only_labels(["hip", "knee", label, "ankle"]))
    assert markers.names == ("hip", "knee", "ankle")
    found = load_c3d_quantities(only_labels(["hip", label], ANGLE_UNITS="deg", MOMENT_UNITS="Nmm"))
    unit = {"angles": "deg", "moments": "Nmm"}.get(BY_NAME[label], "")
    assert [(name, one.kind, one.unit) for name, one in found.items()] == [(label, BY_NAME[label], unit)]


def test_markers_stay_markers():
    """Whose names have such words in another place, or are points of the body or of things."""
    assert load_c3d(only_labels(MARKERS)).names == tuple(MARKERS)
    assert load_c3d_quantities(only_labels(MARKERS)) == {}


def test_a_model_may_call_a_position_what_it_likes():
    """What MODELED_MARKERS lists is one."""
    assert load_c3d(only_labels(["hip", "MyForce"], MODELED_MARKERS=["MyForce"])).names == ("hip", "MyForce")


@pytest.mark.parametrize(
    ("label", "listed"),
    [("Bob:LKA", "LKA"), ("LKA", "Bob:LKA"), ("LKA", "lka"), ("bob:lka", "Bob:LKA"), ("Bob:LKA", "BOB: LKA")],
)
def test_labels_are_the_same_in_any_case_and_without_the_subject(label, listed):
    data = only_labels(["hip", label], ANGLES=[listed, "other"])
    assert [(name, one.kind) for name, one in load_c3d_quantities(data).items()] == [(label, "angles")]
    data.seek(0)
    with pytest.warns(UserWarning, match="1 of 2 points are no positions of markers and are left out: 1 in POINT:ANG"):
        assert load_c3d(data).names == ("hip",)


def test_two_subjects_are_not_mixed_up():
    data = only_labels(["Ann:X1", "Bob:X1", "knee"], SCALARS=["Bob:X1"])
    assert list(load_c3d_quantities(data)) == ["Bob:X1"]


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


def test_angles_are_no_positions_at_any_scale():
    for unit in ("deg", "RAD", "degrees", "degr"):
        for options in ({}, {"scale": 1.0}, {"scale": 0.001}):
            with pytest.raises(
                MocapFormatError, match=f"POINT:UNITS: .* found '{unit}': these are angles, no positions"
            ):
                load_c3d(only_labels(["hip", "knee"], units=unit), **options)
    with pytest.warns(UserWarning, match="from end to end"):
        assert len(load_c3d(only_labels(["hip", "knee"], units="furlong"), scale=1.0)) == 4
    units = np.zeros(2, int)  # no text: what a scale replaces may be damaged
    assert len(load_c3d(only_labels(["hip", "knee"], units=units), scale=0.001)) == 4
