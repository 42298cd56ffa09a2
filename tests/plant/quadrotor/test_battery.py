"""A battery that sags, against the roots of its load line and the hover that it must leave steady."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from objectives.margins.period import NO_METERS
from plant.backends.stepping import fly_steps, unchanged
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.battery import MAINS, power_of, voltage_of
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import close_loop
from plant.quadrotor.features import vehicle_features
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.vectors import Rotors
from tests.plant.harness import HUMMINGBIRD, LIMITS, TARGETS, batch, default_gains, references, scenario

H = 0.004
PACK = {
    "battery_full": 12.6,
    "battery_empty": 10.5,
    "battery_resistance": 0.06,
    "battery_capacity": 7200.0,
    "hover_power": 90.0,
}
WEAK = HUMMINGBIRD._replace(**PACK, battery_used=5400.0)
HOVER = 0.25 * WEAK.mass * WEAK.gravity


def under_load(rest: float, power: float) -> float:
    """Voltage at which a battery of that voltage at rest gives a power: the upper root of V^2 - rest V + R P."""
    return float(np.roots([1.0, -rest, PACK["battery_resistance"] * power]).max())


FULL, WORN = under_load(12.6, 90.0), under_load(12.6 - 2.1 * 0.75, 90.0)


def hovering(compensation: float, steps: int = 2000) -> list[Any]:
    """Flight record of every instant of a hover under a PID with an integral."""
    options = ControlOptions(battery_compensation=compensation)
    know, loop = (
        nominal(WEAK, options, H),
        close_loop(close_cascade(LAWS["pid"], LAWS["pid"]), NO_METERS, vehicle_features(WEAK, H)),
    )
    none = np.zeros((1, steps, 12))
    inputs, seen = scenario(batch([WEAK], none, none, references(steps)), 0), []
    fly_steps(
        loop,
        unchanged,
        default_gains(loop),
        know,
        inputs,
        TARGETS,
        LIMITS,
        Timing(H, H),
        lambda _, flight: seen.append(flight),
    )
    return seen


def test_voltage_is_the_root_of_the_load_line() -> None:
    """At hover, at half and at 1.7 times its speed; beyond what the battery can give, half the voltage at rest."""
    battery = nominal(WEAK, ControlOptions(), H).battery
    hover = np.sqrt(HOVER / WEAK.thrust_coefficient)
    assert battery.reference == pytest.approx(FULL, rel=1e-12)
    for times in (0.5, 1.0, 1.7):
        power = power_of(Rotors(*[times * hover] * 4), battery)
        assert power == pytest.approx(90.0 * times**3, rel=1e-12)
        assert voltage_of(5400.0, power, battery) == pytest.approx(under_load(11.025, power), rel=1e-12)
    assert voltage_of(0.0, 1e4, battery) == pytest.approx(6.3, rel=1e-12)


def test_a_hover_asks_for_more_as_the_voltage_falls() -> None:
    """Thrust goes with the square of voltage, so the controller ends up asking for (V_full/V)^2 of the weight, less with
    a compensation, for which the battery is always full.
    """
    plain, made_good = hovering(0.0)[-1], hovering(1.0)[-1]
    sag = FULL / under_load(12.6 - 2.1 * plain.battery.used / 7200.0, 90.0)
    assert sag**2 > 1.3
    assert np.array(plain.in_force) == pytest.approx(HOVER * sag**2, rel=5e-3)
    assert np.array(made_good.in_force) == pytest.approx(HOVER, rel=1e-4)
    for flight in (plain, made_good):
        assert WEAK.thrust_coefficient * np.array(flight.body.rotor_speed) ** 2 == pytest.approx(HOVER, rel=5e-3)


def test_charge_is_the_current_over_time() -> None:
    """In hover, where the current is the power over the voltage."""
    seen = hovering(1.0, 500)
    drawn = seen[-1].battery.used - seen[249].battery.used
    assert drawn == pytest.approx(90.0 / WORN * 250 * H, rel=2e-3)


def test_full_throttle_is_less_on_a_worn_battery() -> None:
    """No compensation asks for more than speed_max, of which the voltage gives its share."""
    fitted, know = vehicle_features(WEAK, H), nominal(WEAK, ControlOptions(battery_compensation=1.0), H)
    hover = Rotors(*[float(np.sqrt(HOVER / WEAK.thrust_coefficient))] * 4)
    kept = fitted.supply.start(hover, know)
    speed, _ = fitted.supply.feed(kept, Rotors(*[WEAK.speed_max] * 4), hover, know, H)
    assert list(speed) == pytest.approx([WEAK.speed_max * WORN / FULL] * 4, rel=1e-12)


def test_a_vehicle_without_a_battery_has_mains() -> None:
    """Its loop keeps nothing of it."""
    assert vehicle_features(HUMMINGBIRD, H).supply is MAINS
    assert vehicle_features(WEAK, H).name == "_sags"


def test_an_airframe_file_may_give_it(tmp_path: Path) -> None:
    """All numbers together, in their order, and no hover beyond what it can give."""
    text = load("f450").path.read_text(encoding="utf-8")
    units = {"battery_resistance": "Ohm", "battery_capacity": "A s", "battery_used": "A s", "hover_power": "W"}

    def written(**values: float) -> Path:
        lines = [
            f'{k} = {{ value = {v}, unit = "{units.get(k, "V")}", source = "a test" }}\n' for k, v in values.items()
        ]
        file = tmp_path / "worn.toml"
        file.write_text(text.replace("[inertia]", "".join(lines) + "\n[inertia]", 1), encoding="utf-8")
        return file

    assert load(written(**PACK)).vehicle == load("f450").vehicle._replace(**PACK)
    with pytest.raises(InputError, match="battery_capacity: is missing"):
        load(written(**{key: value for key, value in PACK.items() if key != "battery_capacity"}))
    with pytest.raises(InputError, match="battery_empty: is 13"):
        load(written(**PACK | {"battery_empty": 13.0}))
    with pytest.raises(InputError, match="at most 0.441 ohm"):
        nominal(HUMMINGBIRD._replace(**PACK | {"battery_resistance": 0.5}), ControlOptions(), H)
