"""PX4's own loops as our laws: the file holds the gains themselves, other thrust models scale them, and what cannot be shared is refused."""

from dataclasses import replace

import numpy as np
import pytest

from plant.errors import InputError
from plant.law_registry import law
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions
from tests.tuner.exchange.flying_autopilots import attitude_feedback, by_address, px4_torque
from tests.tuner.extensions.px4.test_px4 import bundle, values_of
from tuner.extensions.px4.export import FILE
from tuner.gains import Controller

# A gain of each kind away from PX4's default.
TUNED = {
    "roll.p": 0.11, "roll.d": 0.0021, "pitch.i": 0.33, "yaw.ff": 0.02, "yaw.i_limit": 0.2, "x.position_p": 1.1, "z.p": 5.5,
    **{f"{axis}.gyro_cutoff": 70.0 for axis in ("roll", "pitch", "yaw")},
    **{f"{axis}.notch": 85.0 for axis in ("roll", "pitch", "yaw")},
}  # fmt: skip


def own(airframe="f450", **changes):
    frame = load(airframe)
    cascade = close_cascade(law("px4_position"), law("px4"), 8)
    row = default_row(cascade, frame.vehicle)
    chosen = {**TUNED, "y.position_p": 1.1, **changes}
    for gain in gain_addresses(cascade):
        row[gain.column] = chosen.get(gain.address, row[gain.column])
    return Controller(frame, cascade, ControlOptions(), 0.0025, 0.00125, tuple(row))


def test_the_file_holds_the_gains_themselves():
    values = values_of(bundle(own()).files[FILE])
    expected = {
        "MC_ROLLRATE_P": 0.11,
        "MC_ROLLRATE_D": 0.0021,
        "MC_PITCHRATE_P": 0.15,
        "MC_PITCHRATE_I": 0.33,
        "MC_YAWRATE_FF": 0.02,
        "MC_YR_INT_LIM": 0.2,
        "MC_YAW_P": 2.8,
        "MPC_XY_P": 1.1,
        "MPC_Z_VEL_P_ACC": 5.5,
        "IMU_GYRO_CUTOFF": 70.0,
        "IMU_DGYRO_CUTOFF": 30.0,
        "IMU_GYRO_NF0_FRQ": 85.0,
        "MPC_VELD_LP": 5.0,
        "MC_ROLLRATE_K": 1.0,
        "MC_YAW_WEIGHT": 1.0,
    }
    assert {name: values[name] for name in expected} == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("settings", [(), ("thrust_model=local",), ("thrust_curve=0.4",)])
@pytest.mark.parametrize("airframe", ["f450", "iris", "hummingbird-rotors"])
def test_px4_flies_its_loops_as_we_do(airframe, settings):
    """Angles, rates and integrals moved one by one through PX4's cascade, allocation, thrust curve and the rotors' places."""
    given = own(airframe, **{f"{axis}.ff": 0.0 for axis in ("roll", "pitch", "yaw")})
    curve = float(dict(entry.split("=") for entry in settings).get("thrust_curve", 1.0))
    values, vehicle, held = values_of(bundle(given, *settings).files[FILE]), given.airframe.vehicle, by_address(given)
    flown, _ = attitude_feedback(lambda *motion: px4_torque(values, vehicle, curve, *motion), vehicle)
    parts = [
        [held[f"{axis}.{name}"] for axis in ("roll", "pitch", "yaw")] for name in ("authority", "angle_p", "p", "i")
    ]
    authority, outer, p, i = np.array(parts)
    assert flown == pytest.approx(authority * np.array([p * outer + i, i * outer, p]), rel=1e-6)


def test_what_is_held_is_what_was_asked_to_float32():
    given = own()
    made = bundle(given)
    assert made.held.gains == pytest.approx(given.gains, rel=1e-7)
    assert replace(made.held, gains=given.gains, options=given.options) == given
    assert made.gyro is None
    losses = "\n".join(made.differences)
    assert "4 kd ki" not in losses and "derivative filters" not in losses and "those of position each 20 ms" in losses


def test_mixed_laws_carry_each_loop_in_its_own_form():
    cascade = close_cascade(law("pid"), law("px4"))
    given = own()
    row = default_row(cascade, given.airframe.vehicle)
    chosen = {"x.ki": 0.3, "y.ki": 0.3, "z.kp": 5.2, "z.ki": 0.4, "z.kd": 4.0}
    for gain in gain_addresses(cascade):
        row[gain.column] = chosen.get(gain.address, row[gain.column])
    values = values_of(bundle(replace(given, cascade=cascade, gains=tuple(row))).files[FILE])
    assert values["MC_ROLLRATE_P"] == pytest.approx(0.15) and values["MPC_XY_VEL_P_ACC"] == pytest.approx(
        2.6 * 9.80665 / 9.81, rel=1e-3
    )
    assert "MPC_VELD_LP" not in values and values["IMU_GYRO_CUTOFF"] == 40.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"yaw.gyro_cutoff": 60.0}, "yaw.gyro_cutoff: given 60, and roll.gyro_cutoff makes another IMU_GYRO_CUTOFF"),
        ({"y.p": 2.0}, "y.p: given 2, and x.p makes another MPC_XY_VEL_P_ACC"),
        ({"roll.p": 0.7}, "MC_ROLLRATE_P: works out at 0.7 normalised torque per rad/s, allowed 0.01 to 0.5"),
    ],
)
def test_what_px4_cannot_hold_is_refused_by_name(changes, words):
    with pytest.raises(InputError, match=words):
        bundle(own(**changes))
