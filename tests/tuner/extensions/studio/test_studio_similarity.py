"""Speed by similarity in time: poles and flights of a rigid body are scaled exactly; robustness slows outer loops and observers."""

from fractions import Fraction

import numpy as np
import pytest

from plant.errors import InputError
from plant.law_registry import LAWS, law
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.quadrotor.gains import GainAddress
from tests.tuner.extensions.studio.conftest import STUDIES
from tuner.extensions.studio.messages import PageRequest
from tuner.extensions.studio.session import Setting, open_session
from tuner.extensions.studio.similarity import Similarity, seconds_in, speed_power

OF_A_MODEL = {"smith", "model_following", "betaflight_adrc", "adrc1", "ladrc_printed", "hybrid_paper_f_hat"}
"""Laws with a model of the vehicle, which stays, of a plant of first order, or printed with a sum of different units."""


def addresses(of, loop):
    axis = "roll" if loop == "attitude" else "x"
    return [GainAddress(f"{axis}.{g.name.rstrip('_')}", i, axis, loop, g, g.span(loop)) for i, g in enumerate(of.gains)]


def request_of(setting):
    """Request of a page on one setting."""
    return PageRequest(1, "page", (setting,), 1, "")


def moved(study, speed=1.0, robustness=1.0, **values):
    """Values of a study's default, moved to a speed and a robustness, and the notes."""
    session = open_session(STUDIES / f"{study}.toml")
    row = session.row({name.replace("__", "."): value for name, value in values.items()})
    request = request_of(Setting("here", row, "here"))
    answer = Similarity(session).designed(request, {"at": {"speed": speed, "robustness": robustness}})
    return session.values(row), answer["values"], answer["text"]


@pytest.mark.parametrize(
    ("unit", "power"),
    [
        ("rad^(1/2) s^(-3/2)", Fraction(-3, 2)), ("s^2/rad", 2), ("1/rad", 0), ("rad/s", -1), ("kg m^2/s^2", -2), ("N m s/rad", 1),
        ("Hz", 0), ("us", 0), ("1", 0),
    ],
)  # fmt: skip
def test_seconds_are_read_from_a_unit(unit, power):
    assert seconds_in(unit) == power


def pid_poles(kp, ki, kd, t_f):
    """Poles of PID with a filtered derivative on y'' = u, written out: s^2 (Tf s + 1) s + ... = 0."""
    return np.sort_complex(np.roots([t_f, 1.0, kp * t_f + kd, kp + ki * t_f, ki]))


def test_poles_of_a_rigid_body_are_twice_as_far_out_at_twice_the_speed():
    before, after, notes = moved(
        "f450", 1.25, attitude__kp=60.0, attitude__ki=60.0, attitude__kd=14.0, attitude__t_f=0.005
    )
    poles, faster = (
        pid_poles(*(values[f"attitude.{n}"] for n in ("kp", "ki", "kd", "t_f"))) for values in (before, after)
    )
    assert notes == "" and faster == pytest.approx(1.25 * poles, rel=1e-9)


def ladrc_poles(omega_c, zeta, omega_o):
    """Poles of linear ADRC on y'' = u with y and y' measured and a third-order observer, written out.

    u = -kp y - kd y' - z3 and the observer knows u, so its error is free: (s + wo)^3 (s^2 + kd s + kp) = 0.
    """
    return np.sort_complex([*np.roots([1.0, 2.0 * zeta * omega_c, omega_c**2]), -omega_o])


def test_poles_of_adrc_are_scaled_by_speed_and_its_observer_alone_by_robustness():
    names = ("omega_c", "zeta", "omega_o")
    before, after, notes = moved("crazyflie", 2.0, attitude__zeta=0.8, position__zeta=0.7)
    for loop in ("attitude", "position"):
        poles, faster = (ladrc_poles(*(values[f"{loop}.{name}"] for name in names)) for values in (before, after))
        assert faster == pytest.approx(2.0 * poles, rel=1e-9)
    assert notes == ""
    before, after, _ = moved("crazyflie", robustness=2.0)
    changed = {name: after[name] / before[name] for name in before if after[name] != before[name]}
    assert changed == pytest.approx({"attitude.omega_o": 0.5, "position.omega_o": 0.5})


def flight(of, values, h, steps=60, size=1e-3):
    """Positions of y'' = u under a law, from an error on, in control periods; u is held, so the flight is exact."""
    constants = of.prepare(of.Gains(*values), h)
    y = rate = effect = 0.0
    memory, channel, out = of.start(constants, Measured(0.0, 0.0), 0.0), Channel(1.0, 0.0), []
    for _ in range(steps):
        u, memory = of.step(
            memory, constants, channel, Setpoint(size, 0.0, 0.0), Measured(y, rate), Applied(effect, 0.0), h
        )
        y, rate, effect = y + h * rate + 0.5 * h * h * u, rate + h * u, u
        out.append(y)
    return np.array(out)


@pytest.mark.parametrize("loop", ["attitude", "position"])
@pytest.mark.parametrize("name", [name for name in LAWS if name not in OF_A_MODEL])
def test_a_flight_of_a_rigid_body_is_the_same_in_a_faster_time(name, loop):
    of = law(name)
    gains = addresses(of, loop)
    values = [0.0 if gain.unit == "Hz" or gain.info.name == "relax" else gain.default for gain in gains]
    scaled = [value * 1.5 ** speed_power(gain, gains) for gain, value in zip(gains, values, strict=True)]
    slow, fast = flight(of, values, 0.003), flight(of, scaled, 0.002)
    assert np.ptp(slow) > 1e-6
    # The error at which PX4 stops its integral stays, and takes 1e-7 of the integral here.
    assert fast == pytest.approx(slow, rel=1e-5, abs=1e-12)


def test_robustness_of_nested_loops_slows_the_outer_one_at_the_same_inner_one():
    before, after, notes = moved(
        "autopilot_pid", robustness=1.15, horizontal__kp=3.0, horizontal__ki=0.15, horizontal__kd=2.6
    )
    poles, slower = (
        pid_poles(values["horizontal.kp"], values["horizontal.ki"], values["horizontal.kd"], 0.0)[-3:]
        for values in (before, after)
    )
    assert notes == "" and 1.15 * slower == pytest.approx(poles, rel=1e-9)
    assert {name: after[name] for name in after if name.startswith("tilt.")} == {
        name: before[name] for name in before if name.startswith("tilt.")
    }


@pytest.mark.parametrize(
    ("study", "ratios"),
    [
        ("px4", {"horizontal.position_p": 1 / 1.2, "horizontal.p": 1 / 1.2, "horizontal.i": 1 / 1.44}),
        # Only attitude is searched: a slower angle loop within a fixed position loop would take margin from it.
        ("ardupilot", {"tilt.i": 1 / 1.2}),
        ("f450", {"position.omega_o": 1 / 1.2}),
        ("betaflight", {}),
    ],
)
def test_robustness_slows_position_loops_observers_or_the_integral(study, ratios):
    before, after, notes = moved(study, robustness=1.2)
    changed = {name: after[name] / before[name] for name in before if after[name] != before[name]}
    assert changed == pytest.approx(ratios) and notes == ""


def test_a_slider_that_would_move_nothing_is_not_offered():
    offers = Similarity(open_session(STUDIES / "betaflight.toml")).offers
    assert offers is not None
    assert [slider["key"] for slider in offers["sliders"]] == ["speed"]


def test_gains_of_firmware_follow_their_meaning_and_filters_stay():
    before, after, _ = moved("px4", 0.8)
    ratios = {name: after[name] / before[name] for name in before}
    assert ratios == pytest.approx({
        "tilt.angle_p": 0.8, "tilt.p": 0.8, "tilt.i": 0.64, "tilt.d": 1.0, "attitude.gyro_cutoff": 1.0, "attitude.d_cutoff": 1.0,
        "horizontal.position_p": 0.8, "horizontal.p": 0.8, "horizontal.i": 0.64,
    })  # fmt: skip
    before, after, _ = moved("betaflight", 1.5)
    assert after["tilt.p"] == round(1.5 * before["tilt.p"])


def test_a_gain_that_would_leave_its_range_ends_there_with_a_note():
    _, values, notes = moved("quickstart", 2.0)
    assert values["attitude.k1"] == 40.0 and "attitude.k1: the rule gives 56.57, the range ends at 40." in notes


def test_a_value_outside_its_range_stays_where_it_is_not_scaled():
    before, after, notes = moved("autopilot_pid", robustness=1.1)
    assert before["tilt.kp"] == after["tilt.kp"] == 60.0 and "tilt" not in notes


def test_sliders_start_from_the_setting_at_hand():
    session = open_session(STUDIES / "quickstart.toml")
    rules, row = Similarity(session), session.row({"attitude.omega_o": 12.0})
    request = request_of(Setting("here", row, "here"))
    answer = rules.designed(request, {"from": {"speed": 1.5}, "at": {"speed": 3.0}})
    assert answer["values"]["attitude.omega_o"] == pytest.approx(24.0)
    assert rules.offers is not None and "roll delta; pitch delta; yaw delta" in rules.offers["note"]


@pytest.mark.parametrize(
    "message", [{"at": {"speed": 0.1}}, {"at": {"robustness": 9.0}}, {"from": {"speed": 5.0}}, {"at": 3}]
)
def test_numbers_outside_the_sliders_are_refused(message):
    session = open_session(STUDIES / "quickstart.toml")
    with pytest.raises(InputError, match="allowed: "):
        Similarity(session).designed(request_of(session.start), message)
