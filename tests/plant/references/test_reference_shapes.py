"""What each reference draws, against closed forms of its own."""

from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from plant.errors import InputError
from plant.references import build, from_mapping
from plant.references.blend import blend
from plant.references.spec import ACCELERATION, HOLD, PITCH, POSITION, ROLL, VELOCITY, YAW, YAW_RATE

DT = 0.004


def samples_of(seconds: float, **table: object) -> np.ndarray:
    """Return the samples of a reference table."""
    return build(from_mapping(table), DT, round(seconds / DT) + 1).samples


def test_hover_is_the_origin() -> None:
    """Nothing but hold."""
    expected = np.zeros((501, 14))
    expected[:, HOLD] = 1.0
    np.testing.assert_array_equal(samples_of(2.0, kind="hover"), expected)


def test_level_asks_for_nothing_but_attitude() -> None:
    """All zero, hold included: x and y are free."""
    np.testing.assert_array_equal(samples_of(2.0, kind="level"), np.zeros((501, 14)))


def test_steps_switch_at_their_time() -> None:
    """All axes switch at the first sample at or after the time; angles arrive in radians."""
    track = build(from_mapping({"kind": "steps", "x": 1.5, "z": -1, "yaw_deg": 90.0, "time": 1.0}), DT, 500)
    np.testing.assert_array_equal(track.samples[:250, :HOLD], 0.0)
    np.testing.assert_allclose(track.final, [1.5, 0.0, -1.0, 0.0, 0.0, pi / 2])
    np.testing.assert_array_equal(track.samples[250:, POSITION], np.tile([1.5, 0.0, -1.0], (250, 1)))
    np.testing.assert_allclose(track.samples[250:, YAW], pi / 2)
    assert not np.any(track.samples[:, VELOCITY])
    assert track.step_time == 1.0
    assert np.all(track.samples[:, HOLD] == 1.0)


@pytest.mark.parametrize("dt", [0.001, 0.004, 0.0055])
def test_steps_come_neither_early_nor_late(dt: float) -> None:
    """The step is at the first sample k with k dt >= time, also where k dt falls an ulp short of it."""
    for k in range(1, 300):
        as_written = float(f"{k * dt:.4f}")  # 0.0275 s, where 5 * 0.0055 is an ulp less
        for time in (as_written, as_written - 0.5 * dt):
            samples = build(from_mapping({"kind": "steps", "x": 1.0, "time": time}), dt, 300).samples
            assert int(np.argmax(samples[:, 0])) == k


def test_steps_of_roll_and_pitch_let_go_of_the_position() -> None:
    """Attitude mode holds for the whole flight, before the step, too."""
    track = build(from_mapping({"kind": "steps", "roll_deg": 10.0, "pitch_deg": -5.0, "z": 1.0, "time": 0.5}), DT, 250)
    assert np.all(track.samples[:, HOLD] == 0.0)
    assert track.samples[-1, ROLL] == pytest.approx(radians(10.0))
    assert track.samples[-1, PITCH] == pytest.approx(radians(-5.0))
    assert track.samples[-1, 2] == 1.0
    np.testing.assert_allclose(track.final, [0, 0, 1, radians(10.0), radians(-5.0), 0])


def test_ramp_runs_at_its_rate_and_ends_on_its_level() -> None:
    """Between the blends the rate is exact; the whole way is rate (stop - start)."""
    samples = samples_of(8.0, kind="ramp", x_rate=2.0, y_rate=-1.0, yaw_rate_deg=36.0, start=1.0, stop=5.0, blend=0.5)
    steady = samples[400:1250]  # 1.6 s to 5 s
    np.testing.assert_allclose(steady[:, VELOCITY], np.tile([2.0, -1.0, 0.0], (850, 1)), rtol=1e-12)
    np.testing.assert_allclose(samples[-1, POSITION], [8.0, -4.0, 0.0], rtol=1e-12)
    assert samples[-1, YAW] == pytest.approx(radians(144.0))
    assert samples[400, YAW_RATE] == pytest.approx(radians(36.0))
    np.testing.assert_array_equal(samples[:251, :HOLD], 0.0)
    np.testing.assert_allclose(samples[1400:, VELOCITY], 0.0, atol=1e-15)


def test_ramp_shorter_than_its_blend_still_ends_on_its_level() -> None:
    """The two changes of pace may overlap."""
    samples = samples_of(5.0, kind="ramp", z_rate=1.0, start=1.0, stop=1.2, blend=2.0)
    assert samples[-1, 2] == pytest.approx(0.2)
    assert np.max(samples[:, 5]) < 1.0


def test_blend_integral_is_half_of_its_duration() -> None:
    """By symmetry, reaching the pace costs half a blend; afterwards the integral grows with time."""
    result = blend(np.array([0.0, 1.0, 2.0, 3.0, 4.5]), 1.0, 2.0)
    np.testing.assert_allclose(result.share, [0.0, 0.0, 0.5, 1.0, 1.0])
    np.testing.assert_allclose(result.integral, [0.0, 0.0, 5.0 / 16.0 * 0.5, 1.0, 2.5])


def test_figure_eight_lies_on_its_curve() -> None:
    """Oracle: the lemniscate of Gerono, y^2 = x^2 (1 - (x / size)^2), run through once per period at full pace."""
    samples = samples_of(25.0, kind="figure_eight", size=3.0, period=5.0)
    x, y = samples[:, 0], samples[:, 1]
    np.testing.assert_allclose(y**2, x**2 * (1.0 - (x / 3.0) ** 2), atol=1e-12)
    assert np.ptp(x) == pytest.approx(6.0, rel=1e-4)
    assert np.ptp(y) == pytest.approx(3.0, rel=1e-4)
    assert not np.any(samples[:, 2])
    period = round(5.0 / DT)
    np.testing.assert_allclose(samples[period:-period], samples[2 * period :], atol=1e-12)
    # Through the middle at 45 degrees and sqrt(2) size w: the fastest point.
    assert np.max(np.hypot(*samples[:, :5].T[3:5])) == pytest.approx(np.sqrt(2.0) * 3.0 * 2.0 * pi / 5.0, rel=1e-4)


def test_helix_circles_and_climbs() -> None:
    """Oracle at full pace: distance R from its axis, speed R w, acceleration R w^2 towards the axis, steady climb."""
    samples = samples_of(20.0, kind="helix", radius=2.0, period=4.0, climb_rate=0.25)
    from_axis = samples[:, POSITION] + np.array([2.0, 0.0, 0.0])
    np.testing.assert_allclose(np.hypot(from_axis[:, 0], from_axis[:, 1]), 2.0, rtol=1e-12)
    full = samples[round(4.0 / DT) :]
    w = 2.0 * pi / 4.0
    np.testing.assert_allclose(np.hypot(full[:, 3], full[:, 4]), 2.0 * w, rtol=1e-12)
    np.testing.assert_allclose(full[:, ACCELERATION][:, :2], -(w**2) * from_axis[round(4.0 / DT) :, :2], atol=1e-10)
    np.testing.assert_allclose(full[:, 5], 0.25, rtol=1e-12)
    turning = from_axis[:, 0] * samples[:, 4] - from_axis[:, 1] * samples[:, 3]
    assert np.all(turning >= 0.0)  # counter-clockwise seen from above


CONFLICTS = [
    ({"kind": "steps"}, "reference", "no axis steps"),
    ({"kind": "steps", "x": 0.0, "yaw_deg": 0}, "reference", "no axis steps"),
    ({"kind": "steps", "x": 1.0, "roll_deg": 5.0}, "reference.x", "leave x and y free"),
    ({"kind": "steps", "y": 1.0, "pitch_deg": 5.0}, "reference.y", "leave x and y free"),
    ({"kind": "steps", "roll_deg": 41.0}, "reference.roll_deg", "must be at least -40 and at most 40 deg"),
    ({"kind": "steps", "yaw_deg": -181.0}, "reference.yaw_deg", "is -181 deg"),
    ({"kind": "steps", "x": 1.0, "time": 0.0}, "reference.time", "must be above 0 s"),
    ({"kind": "ramp", "stop": 3.0}, "reference", "no axis moves"),
    ({"kind": "ramp", "x_rate": 1.0, "stop": 1.0}, "reference.stop", "must be after start = 1 s"),
    ({"kind": "ramp", "x_rate": 1.0, "stop": 3.0, "blend": 0.0}, "reference.blend", "must be above 0 s"),
    ({"kind": "ramp", "x_rate": 1.0, "stop": 3.0, "start": -1.0}, "reference.start", "must be at least 0 s"),
    ({"kind": "figure_eight", "size": -1.0, "period": 4.0}, "reference.size", "must be above 0 m"),
    ({"kind": "helix", "radius": 1.0, "period": 0.0}, "reference.period", "must be above 0 s"),
]


@pytest.mark.parametrize(("table", "key", "says"), CONFLICTS)
def test_what_cannot_be_flown_is_refused(table: dict[str, object], key: str, says: str) -> None:
    """Ranges, and keys that contradict each other."""
    with pytest.raises(InputError) as caught:
        from_mapping(table)
    assert caught.value.key == key
    assert says in caught.value.message


def test_a_step_after_the_flight_is_refused() -> None:
    """Only the flight's length shows it, so building does."""
    spec = from_mapping({"kind": "steps", "x": 1.0, "time": 2.0})
    assert build(spec, DT, 501).samples[-1, 0] == 1.0
    with pytest.raises(InputError, match="the flight ends at 1.996 s") as caught:
        build(spec, DT, 500)
    assert caught.value.key == "time"


def test_paths_start_at_the_study(tmp_path: Path) -> None:
    """A relative path starts at the base, an absolute one does not."""
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "a.csv").write_text("t,x,y,z\n0,0,0,0\n1,1,2,3\n")
    relative = from_mapping({"kind": "waypoints", "path": "inner/a.csv"}, base=tmp_path)
    absolute = from_mapping({"kind": "waypoints", "path": str(tmp_path / "inner" / "a.csv")}, base=tmp_path / "inner")
    assert relative == absolute
