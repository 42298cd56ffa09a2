"""Facts of parameter files on their vehicle: values by the firmware's arithmetic, another class contradicted, vehicles narrowed."""

from dataclasses import replace
from math import log, pi, sqrt

import numpy as np
import pytest

import tuner
from plant.input_files import InputFile
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.vectors import Rotors
from tests.tuner.exchange.reading import write
from tuner.documents.assessment import EXIT_CODES
from tuner.extensions.autopilots.sources import sources
from tuner.extensions.autopilots.vehicle_facts import HOVER, VehicleFact, exactly
from tuner.extensions.judge.vehicle_class import class_airframe
from tuner.extensions.judge.vehicle_facts import contradictions, narrowed, spread_of
from tuner.extensions.judge.vehicle_files import GivenFiles

GRAVITY = 9.81
# Mass [kg], arm [m], thrust coefficient [N s2], largest speed [rad/s], cells.
CLASSES = {
    "65 mm": (0.027, 0.0325, 5.0e-9, 6780.0, 1),
    "5 inch": (0.6, 0.11, 1.5e-6, 3200.0, 6),
    "7 inch": (1.1, 0.16, 4.26e-6, 2115.0, 6),
    "10 inch": (1.4, 0.225, 1.11e-5, 1007.0, 3),
    "15 inch": (5.0, 0.4, 9.0e-5, 520.0, 12),
}
PX4 = "# Stack: PX4 Pro\n# Version: 1.16.0\n1\t1\tMC_ROLLRATE_P\t0.15\t9\n"
ARDUPILOT = "# ArduCopter V4.6.1\nATC_RAT_RLL_P,0.135\nATC_RAT_PIT_P,0.135\n"
BETAFLIGHT = "# Betaflight / S7X2 (S7X2) {}.0 Jul  1 2026 / 00:00:00 (abc) MSP API: 1.48\nprofile 0\nset p_roll = 45\n"
CRAZYFLIE = (
    "type: persistent_param_state\nversion: '1'\nparams:\n"
    "  posCtlPid.thrustBase: {{is_stored: true, default_value: 36000, stored_value: {}}}\n"
)


def airframe_of(name):
    mass, arm, coefficient, speed, cells = CLASSES[name]
    side = arm / sqrt(2.0)
    vehicle = load("f450").vehicle._replace(
        mass=mass, thrust_coefficient=coefficient, speed_max=speed, battery_full=4.2 * cells, gravity=GRAVITY,
        rotor_x=Rotors(side, side, -side, -side), rotor_y=Rotors(side, -side, side, -side),
    )  # fmt: skip
    return replace(load("f450"), name=name, vehicle=vehicle)


def numbers_of(name):
    """Motor command at hover [1], rotor speed at hover [Hz], arm [m] and cells, from the balance of weight and thrust."""
    mass, arm, coefficient, speed, cells = CLASSES[name]
    hover = sqrt(mass * GRAVITY / (4.0 * coefficient))
    return hover / speed, hover / (2.0 * pi), arm, cells


def px4_lines(rows):
    return PX4 + "".join(f"1\t1\t{name}\t{value:.6g}\t9\n" for name, value in rows.items())


def px4_file(name):
    """Thrust curve of 0.3, motors 1 front right, 2 rear left, 3 front left, 4 rear right, PX4's y to the right."""
    command, _, arm, _ = numbers_of(name)
    rows = {"THR_MDL_FAC": 0.3, "MPC_THR_HOVER": 0.3 * command**2 + 0.7 * command, "CA_ROTOR_COUNT": 4}
    for rotor, (x, y) in enumerate(((1, 1), (-1, -1), (1, -1), (-1, 1))):
        rows |= {f"CA_ROTOR{rotor}_PX": x * arm / sqrt(2.0), f"CA_ROTOR{rotor}_PY": y * arm / sqrt(2.0)}
    return px4_lines(rows)


def ardupilot_file(name):
    """Motors between 0.15 and 0.95 of the command, thrust curve of 0.65; a notch that was set up at a throttle of 0.3."""
    command, frequency, _, _ = numbers_of(name)
    spun = (command - 0.15) / 0.8
    throttle = 0.65 * spun**2 + 0.35 * spun
    rows = {
        "MOT_THST_HOVER": throttle, "MOT_THST_EXPO": 0.65, "MOT_SPIN_MIN": 0.15, "MOT_SPIN_MAX": 0.95,
        "INS_HNTCH_ENABLE": 1, "INS_HNTCH_MODE": 1, "INS_HNTCH_REF": 0.3, "INS_HNTCH_FREQ": frequency * sqrt(0.3 / throttle),
    }  # fmt: skip
    return ARDUPILOT + "".join(f"{key},{value:.6g}\n" for key, value in rows.items())


def betaflight_file(name):
    command, _, _, cells = numbers_of(name)
    return (
        BETAFLIGHT.format("2025.12")
        + f"set ap_hover_throttle = {1000 + 1000 * command:.0f}\nset force_battery_cell_count = {cells}\n"
    )


FILES = {"px4": px4_file, "ardupilot": ardupilot_file, "betaflight": betaflight_file}
PAIRS = [(made, flown) for made in CLASSES for flown in CLASSES if made != flown]


def fitting(fact, vehicle):
    values = fact.fitting(vehicle)
    assert values is not None
    return values


def ranges_of(airframe):
    assert airframe.uncertainty is not None
    return airframe.uncertainty


def facts_of(folder, source, text):
    kind = sources()[source]
    return kind.facts(kind.values(InputFile(write(folder, text))))


@pytest.mark.parametrize("source", FILES)
@pytest.mark.parametrize("name", CLASSES)
def test_a_file_of_a_vehicle_has_the_numbers_of_its_airframe(name, source, tmp_path):
    """Each value, by the firmware's arithmetic in this file, lies within 1 % of what the airframe gives."""
    facts = facts_of(tmp_path, source, FILES[source](name))
    vehicle = airframe_of(name).vehicle
    assert len(facts) >= 2 and contradictions(facts, airframe_of(name)) == []
    for fact in facts:
        low, high = fitting(fact, vehicle)
        assert low / 1.01 <= fact.value <= 1.01 * high


@pytest.mark.parametrize(("source", "least"), [("px4", 20), ("ardupilot", 18), ("betaflight", 18)])
def test_an_airframe_of_another_class_is_contradicted(source, least, tmp_path):
    """Of 60 pairs 56; of a 5 and a 7 inch vehicle of six cells commands and rotor speeds at hover are within 1.25."""
    found = {
        pair: contradictions(facts_of(tmp_path, source, FILES[source](pair[0])), airframe_of(pair[1])) for pair in PAIRS
    }
    missed = {pair for pair, rows in found.items() if not rows}
    assert len(PAIRS) - len(missed) == least and all(set(pair) == {"5 inch", "7 inch"} for pair in missed)


def test_facts_of_a_class_are_those_of_the_same_class_within_its_ranges(tmp_path):
    """The class has thrust within a factor of 11: a hover command is no contradiction, an arm is."""
    facts = facts_of(tmp_path, "px4", px4_file("7 inch"))
    assert [row.fact.quantity.name for row in contradictions(facts, class_airframe("px4"))] == ["arm"]
    assert contradictions(facts_of(tmp_path, "ardupilot", ardupilot_file("10 inch")), class_airframe("ardupilot")) == []


NO_FACTS = {
    "the default of PX4": ("px4", px4_lines({"MPC_THR_HOVER": 0.5, "BAT1_N_CELLS": 0})),
    "the default of ArduPilot": ("ardupilot", ARDUPILOT + "MOT_THST_HOVER,0.35\nMOT_HOVER_LEARN,2\nMOT_BAT_VOLT_MAX,0\n"),
    "the default of Betaflight": ("betaflight", BETAFLIGHT.format("2025.12") + "set ap_hover_throttle = 1275\n"),
    "the default of the Crazyflie": ("crazyflie", CRAZYFLIE.format(36000)),
    "a generic frame": (
        "px4", px4_lines({f"CA_ROTOR{i}_P{axis}": sign * 0.15 for i, signs in enumerate(("++", "--", "+-", "-+"))
                          for axis, sign in zip("XY", (int(f"{one}1") for one in signs), strict=True)}),
    ),
    "rotors on a line": ("px4", px4_lines({f"CA_ROTOR{i}_P{axis}": 0.2 * i * (axis == "X") for i in range(4) for axis in "XY"})),
    "numbers without a meaning": ("px4", px4_lines({"MPC_THR_HOVER": -3.0, "BAT1_N_CELLS": 1e30, "CA_ROTOR0_PX": 1e30})),
    "no throttle": ("ardupilot", ARDUPILOT + "MOT_THST_HOVER,0\n"),
    "a notch at measured speeds": (
        "ardupilot", ARDUPILOT + "INS_HNTCH_ENABLE,1\nINS_HNTCH_MODE,3\nINS_HNTCH_REF,1\nINS_HNTCH_FREQ,40\n",
    ),
    "a word": ("betaflight", BETAFLIGHT.format("2025.12") + "set ap_hover_throttle = AUTO\n"),
}  # fmt: skip


@pytest.mark.parametrize(("source", "text"), NO_FACTS.values(), ids=NO_FACTS)
def test_a_default_and_a_placeholder_are_no_facts(source, text, tmp_path):
    assert facts_of(tmp_path, source, text) == []


@pytest.mark.parametrize(
    ("source", "text", "value"),
    [
        ("betaflight", BETAFLIGHT.format("4.5") + "set gps_rescue_throttle_hover = 1420\n", 0.42),
        ("crazyflie", CRAZYFLIE.format(26214), 0.4),
        ("ardupilot", "#ArduCopter V3.3.3\nRATE_RLL_P,0.1\nTHR_MID,420\n", 0.42),
    ],
)
def test_older_names_and_counts_are_read(source, text, value, tmp_path):
    (fact,) = facts_of(tmp_path, source, text)
    assert fact.quantity is HOVER and fact.value == pytest.approx(value, rel=1e-4)


def test_a_learned_throttle_at_the_end_of_its_range_is_a_limit(tmp_path):
    """AP_MOTORS_THST_HOVER_MIN = 0.125: a vehicle that hovers at 0.06 has 0.125 in its file, and is not contradicted."""
    (fact,) = facts_of(tmp_path, "ardupilot", ARDUPILOT + "MOT_THST_HOVER,0.125\nMOT_SPIN_MIN,0\nMOT_SPIN_MAX,1\n")
    strong = load("f450").vehicle._replace(mass=0.1)
    assert fitting(fact, strong)[1] < 0.1 and contradictions([fact], replace(load("f450"), vehicle=strong)) == []


def test_a_dynamic_notch_that_the_rotors_leave_is_a_warning(tmp_path):
    """15 inch propellers turn at 58 Hz in hover; a notch of a 65 mm vehicle begins at 100 Hz."""
    facts = facts_of(tmp_path, "betaflight", BETAFLIGHT.format("2025.12") + "set dyn_notch_min_hz = 100\n")
    (row,) = contradictions(facts, airframe_of("15 inch"))
    assert not row.refuses and contradictions(facts, airframe_of("65 mm")) == []
    assert row.sentence("it") == (
        "dyn_notch_min_hz = 100 Hz in the file, it turns its rotors in hover at 58.7 Hz, a factor 1.7 away"
    )


def hover_fact(value, tolerance=0.1):
    quantity = replace(HOVER, tolerance=tolerance)
    return VehicleFact(quantity, "hover", value, exactly(lambda one: actuation(one).hover_command))


def test_narrowed_vehicles_are_those_with_the_hover_command_of_the_file():
    """Against draws of the class weighted by the probability of the file's value: hover command, mass and thrust coefficient."""
    airframe, value, tolerance = class_airframe("px4"), 0.4, 0.1
    ranges, rng = ranges_of(airframe), np.random.default_rng(1)
    steps = rng.standard_normal((20000, len(ranges.names))) @ ranges.axes.T
    logarithms = np.array([log(actuation(ranges.moved(airframe.vehicle, step)).hover_command) for step in steps])
    weights = np.exp(-0.5 * ((log(value) - logarithms) / tolerance) ** 2)
    narrow = narrowed(airframe, [hover_fact(value, tolerance)])
    for name, middle in (("mass", narrow.vehicle.mass), ("thrust_coefficient", narrow.vehicle.thrust_coefficient)):
        column = steps[:, ranges.names.index(name)]
        mean = np.average(column, weights=weights)
        deviation = sqrt(np.average((column - mean) ** 2, weights=weights))
        assert log(middle / getattr(airframe.vehicle, name)) == pytest.approx(mean, abs=0.02)
        assert ranges_of(narrow).deviations[ranges.names.index(name)] == pytest.approx(deviation, rel=0.03)
        assert narrow.sources[name].value == pytest.approx(middle)
    assert log(actuation(narrow.vehicle).hover_command) == pytest.approx(
        np.average(logarithms, weights=weights), abs=0.01
    )
    # Lag and drag have nothing to do with it.
    for name in ("lag_up", "drag_linear.z"):
        index = ranges.names.index(name)
        assert ranges_of(narrow).deviations[index] == pytest.approx(ranges.deviations[index], rel=1e-3)
    assert spread_of(hover_fact(value), narrow) < tolerance < spread_of(hover_fact(value), airframe)


def test_an_airframe_without_ranges_stays_as_it_is():
    airframe = load("f450")
    assert narrowed(airframe, [hover_fact(0.3)]) is airframe


def test_another_vehicle_is_not_judged_and_a_near_one_is_noted(tmp_path):
    """On f450, which hovers at a motor command of 0.554."""
    far = tuner.judge(write(tmp_path, px4_lines({"MPC_THR_HOVER": 0.205}), "far.params"), airframe="f450", flights=2)
    assert far.verdict == "not judged" and far.exit_code == EXIT_CODES["not judged"] == 3
    assert far.document.sentence == (
        "Not judged: MPC_THR_HOVER = 0.205 in the file, the airframe f450 hovers at 0.554, a factor 2.7 away: give the "
        "airframe of this vehicle with --airframe."
    )
    near = tuner.judge(write(tmp_path, px4_lines({"MPC_THR_HOVER": 0.4}), "near.params"), airframe="f450", flights=2)
    assert near.verdict != "not judged"
    assert near.document.unmodeled[0].startswith("MPC_THR_HOVER = 0.4 in the file, the airframe f450 hovers at 0.554")


def test_a_number_that_the_export_computed_narrows_no_class(tmp_path):
    """The export writes the hover command of the airframe that it was made for: it is no measurement."""
    text = px4_lines({"MPC_THR_HOVER": 0.3})
    measured, exported = (
        GivenFiles("px4", InputFile(write(tmp_path, head + text, name)), None, None, None)
        for name, head in (
            ("measured.params", ""),
            ("exported.params", "# Written by gainproof 0.2.0 from the gains 0\n"),
        )
    )
    assert measured.vehicle != measured.chosen and exported.vehicle == exported.chosen
    assert [fact.value for fact in exported.facts] == [fact.value for fact in measured.facts] != []


def test_a_class_is_narrowed_by_the_present_file_and_contradicted_by_both(tmp_path):
    present = write(tmp_path, px4_lines({"MPC_THR_HOVER": 0.3}), "present.params")
    proposed = write(tmp_path, px4_lines({"MC_ROLLRATE_P": 0.15, "MC_PITCHRATE_P": 0.14}), "proposed.params")
    document = tuner.judge(proposed, present, flights=2).document
    assert "class of a quadrotor of 450 mm, narrowed by MPC_THR_HOVER = 0.3: mass" in document.sentence
    places = {f"CA_ROTOR{i}_P{axis}": 0.03 * sign for i, signs in enumerate(((1, 1), (-1, -1), (1, -1), (-1, 1)))
              for axis, sign in zip("XY", signs, strict=True)}  # fmt: skip
    small = tuner.judge(write(tmp_path, px4_lines(places), "small.params"), flights=2)
    assert (
        small.verdict == "not judged" and "arm of CA_ROTORi_PX and CA_ROTORi_PY = 0.0424 m" in small.document.sentence
    )
    assert "the class of a quadrotor of 450 mm has an arm of" in small.document.sentence
