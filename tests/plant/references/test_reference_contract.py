"""What every registered reference promises: shapes, a start at rest, rates that belong to positions, checked keys."""

import pickle
from dataclasses import FrozenInstanceError
from pathlib import Path

import numpy as np
import pytest

from plant.errors import InputError, UnknownNameError
from plant.references import REFERENCES, ReferenceSpec, Track, build, from_mapping, parameters
from plant.references.spec import ACCELERATION, HOLD, PITCH, POSITION, ROLL, VELOCITY, WIDTH, YAW, YAW_RATE
from plant.references.track import Reference

CSV = "t,x,y,z,yaw_deg\n0,0,0,0,0\n2,1,0.5,0.2,40\n3.5,2,-1,0,90\n6,0,0,1,-30\n"
TABLES: dict[str, dict[str, object]] = {
    "hover": {},
    "level": {},
    "steps": {"x": 1.0, "y": -2.0, "z": 0.5, "yaw_deg": 20, "time": 1.0},
    "ramp": {"x_rate": 1.0, "z_rate": -0.5, "yaw_rate_deg": 30.0, "start": 1.0, "stop": 4.0, "blend": 0.8},
    "figure_eight": {"size": 2.0, "period": 5.0},
    "helix": {"radius": 1.5, "period": 4.0, "climb_rate": 0.3},
    "waypoints": {"path": "route.csv"},
}
SMOOTH = [kind for kind in TABLES if kind != "steps"]
SECONDS = 12.0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder that holds the waypoints."""
    (tmp_path / "route.csv").write_text(CSV)
    return tmp_path


def spec_of(kind: str, folder: Path, **changes: object) -> ReferenceSpec:
    """Return the example of a kind, with some of its keys changed."""
    return from_mapping({"kind": kind, **TABLES[kind], **changes}, base=folder)


def flown(spec: ReferenceSpec, dt: float) -> Track:
    """Return 12 s of a reference."""
    return build(spec, dt, round(SECONDS / dt))


def test_every_registered_reference_is_under_contract() -> None:
    """A new reference needs an example here, under the name that it calls itself."""
    assert set(TABLES) == set(REFERENCES)
    assert all(kind.kind == name for name, kind in REFERENCES.items())


def test_columns_are_the_leaves_of_a_reference() -> None:
    """The columns' names agree with the kernels' tuple, whose three vectors come first."""
    fields = Reference._fields
    assert fields[:3] == ("position", "velocity", "acceleration")
    assert (POSITION, VELOCITY, ACCELERATION) == (slice(0, 3), slice(3, 6), slice(6, 9))
    offset = 3 * 3 - 3
    columns = {"roll": ROLL, "pitch": PITCH, "yaw": YAW, "yaw_rate": YAW_RATE, "hold": HOLD}
    assert columns == {name: fields.index(name) + offset for name in fields[3:]}
    assert len(fields) + offset == WIDTH


@pytest.mark.parametrize("kind", REFERENCES)
def test_shapes_and_rest_at_the_start(kind: str, folder: Path) -> None:
    """(K, 14) finite float64, at rest and on the starting level at t = 0, one hold for the whole flight."""
    track = flown(spec_of(kind, folder), 0.004)
    assert track.samples.shape == (3000, 14)
    assert track.samples.dtype == np.float64
    assert np.all(np.isfinite(track.samples))
    assert not np.any(track.samples[0, VELOCITY])
    assert not np.any(track.samples[0, ACCELERATION])
    assert track.samples[0, YAW_RATE] == 0.0
    np.testing.assert_array_equal(track.samples[0, [0, 1, 2, ROLL, PITCH, YAW]], track.start)
    assert set(track.samples[:, HOLD]) == {0.0 if kind == "level" else 1.0}


@pytest.mark.parametrize("kind", REFERENCES)
def test_same_spec_same_bits_and_longer_flights_only_add(kind: str, folder: Path) -> None:
    """A reference is a pure function of time: a longer flight begins with the shorter one."""
    short, long = build(spec_of(kind, folder), 0.004, 700), build(spec_of(kind, folder), 0.004, 2000)
    np.testing.assert_array_equal(short.samples, long.samples[:700])


@pytest.mark.parametrize("dt", [0.001, 0.004, 0.01])
@pytest.mark.parametrize("kind", SMOOTH)
def test_rates_are_those_of_the_positions(kind: str, dt: float, folder: Path) -> None:
    """Central differences agree with the analytic rates.

    With J the largest jerk, the mean of v over [t - dt, t + dt] differs from v(t) by at most J dt^2 / 6 (the linear
    part cancels), and the mean of a from a(t) by at most J dt / 2. J is taken from the accelerations' differences, with
    10 % for what falls between samples.
    """
    samples = flown(spec_of(kind, folder), dt).samples
    yaw, yaw_rate = samples[:, [YAW]], samples[:, [YAW_RATE]]
    yaw_acceleration = np.gradient(yaw_rate, dt, axis=0)
    place = (samples[:, POSITION], samples[:, VELOCITY], samples[:, ACCELERATION])
    for p, v, a in (place, (yaw, yaw_rate, yaw_acceleration)):
        jerk = 1.1 * np.max(np.abs(np.diff(a, axis=0))) / dt
        assert np.max(np.abs((p[2:] - p[:-2]) / (2.0 * dt) - v[1:-1])) <= jerk * dt**2 / 6.0 + 1e-11
        assert np.max(np.abs((v[2:] - v[:-2]) / (2.0 * dt) - a[1:-1])) <= jerk * dt / 2.0 + 1e-11


@pytest.mark.parametrize("kind", SMOOTH)
def test_smooth_references_do_not_kick(kind: str, folder: Path) -> None:
    """Acceleration is continuous, at the start, too: halving dt halves its largest change from sample to sample."""
    accelerations = [flown(spec_of(kind, folder), dt).samples[:, ACCELERATION] for dt in (0.002, 0.001)]
    coarse, fine = (np.max(np.abs(np.diff(acceleration, axis=0))) for acceleration in accelerations)
    assert fine <= 0.51 * coarse


@pytest.mark.parametrize("kind", SMOOTH)
def test_smooth_references_make_no_step(kind: str, folder: Path) -> None:
    """Their levels are equal, so that step metrics do not apply."""
    track = flown(spec_of(kind, folder), 0.004)
    np.testing.assert_array_equal(track.start, track.final)
    assert track.step_time == 0.0


@pytest.mark.parametrize("kind", REFERENCES)
def test_specs_are_frozen_values(kind: str, folder: Path) -> None:
    """Equal tables give equal specs; they cannot be changed and survive pickling."""
    spec = spec_of(kind, folder)
    assert spec == spec_of(kind, folder)
    assert pickle.loads(pickle.dumps(spec)) == spec
    with pytest.raises(FrozenInstanceError):
        spec.size = 3.0  # pyright: ignore[reportAttributeAccessIssue]


@pytest.mark.parametrize("kind", REFERENCES)
def test_parameters_are_listed_with_unit_and_meaning(kind: str) -> None:
    """A listing can show every key of the example, what is required, and one line about the reference."""
    listed = {parameter.name: parameter for parameter in parameters(REFERENCES[kind])}
    assert set(TABLES[kind]) <= set(listed)
    assert all(parameter.unit and parameter.meaning for parameter in listed.values())
    assert (REFERENCES[kind].__doc__ or "").splitlines()[0].endswith(".")


@pytest.mark.parametrize("kind", REFERENCES)
def test_unknown_keys_are_refused(kind: str, folder: Path) -> None:
    """A key of no reference is refused with the table's key."""
    with pytest.raises(UnknownNameError) as caught:
        spec_of(kind, folder, heigth=3.0)
    assert caught.value.key == "reference.heigth"
    assert "kind" in caught.value.message


@pytest.mark.parametrize(
    ("kind", "name"), [(kind, p.name) for kind, spec in REFERENCES.items() for p in parameters(spec)]
)
@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), True, None, [1.0], ""])
def test_every_parameter_refuses_what_is_no_value(kind: str, name: str, wrong: object, folder: Path) -> None:
    """Non-finite numbers, true and false, and other types are refused at the parameter's own key."""
    with pytest.raises(InputError) as caught:
        from_mapping({"kind": kind, **TABLES[kind], name: wrong}, base=folder, key="scenario.reference")
    assert caught.value.key == f"scenario.reference.{name}"


@pytest.mark.parametrize(
    ("kind", "name"), [(kind, p.name) for kind, s in REFERENCES.items() for p in parameters(s) if p.default is None]
)
def test_required_parameters_are_asked_for(kind: str, name: str, folder: Path) -> None:
    """Leaving a required key out shows the line to write."""
    table = {key: value for key, value in TABLES[kind].items() if key != name}
    with pytest.raises(InputError, match=f"is missing; write {name} = ") as caught:
        from_mapping({"kind": kind, **table}, base=folder)
    assert caught.value.key == f"reference.{name}"


def test_kind_is_checked() -> None:
    """No kind, a kind that is no text, and an unknown one with the nearest."""
    for table in ({}, {"kind": 3}):
        with pytest.raises(InputError, match="must be one of figure_eight, helix, hover") as caught:
            from_mapping(table, key="reference")
        assert caught.value.key == "reference.kind"
    with pytest.raises(UnknownNameError, match="unknown reference 'figure8'; did you mean 'figure_eight'"):
        from_mapping({"kind": "figure8"})


def test_the_table_is_left_as_it_was(folder: Path) -> None:
    """The caller's table is not taken apart."""
    table = {"kind": "waypoints", "path": "route.csv"}
    from_mapping(table, base=folder)
    assert table == {"kind": "waypoints", "path": "route.csv"}
