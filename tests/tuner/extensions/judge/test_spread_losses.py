"""Losses that come from an airframe's ranges: the number that decides, and the verdict "not judged"."""

from dataclasses import replace

import numpy as np
import pytest

import tuner
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.airframes.uncertainty import Uncertainty
from plant.quadrotor.scenarios import ScenarioSpec, drawn_numbers
from tests.tuner.exchange.reading import write
from tuner.extensions.judge import assessing
from tuner.extensions.judge.assessing import STREAM, scenario_setups
from tuner.extensions.judge.spread_losses import spread_reason
from tuner.extensions.judge.vehicle_files import name_files, read_subjects
from tuner.extensions.parts_list.estimate import uncertainty

PX4 = "# Stack: PX4 Pro\n# Version: 1.16.0\n1\t1\tMC_ROLLRATE_P\t0.15\t9\n"
FLIGHTS, SEED, LOSSES = 256, 3, 12


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Flights of the class of PX4, its vehicle, and hover command and lag of the vehicle of each flight."""
    file = write(tmp_path_factory.mktemp("spread"), PX4)
    subjects = read_subjects(name_files(file, None, None, None))
    _, (setup,) = scenario_setups(subjects, FLIGHTS, SEED)[0]
    nominal = subjects.after.gains.controller.airframe.vehicle
    assert isinstance(setup.spec, ScenarioSpec) and setup.spec.uncertainty is not None
    ranges = setup.spec.uncertainty
    steps = drawn_numbers(setup.spec, nominal, SEED, STREAM, range(FLIGHTS)) * np.array(ranges.deviations)
    vehicles = [ranges.moved(nominal, step) for step in steps]
    return (
        setup,
        nominal,
        np.array([actuation(one).hover_command for one in vehicles]),
        np.array([one.lag_up for one in vehicles]),
    )


def least(values, count=LOSSES):
    return values <= np.sort(values)[count - 1]


def none_lost(_):
    return np.zeros(FLIGHTS, dtype=bool)


def test_lost_vehicles_of_low_hover_commands_are_named_with_it(flown):
    setup, nominal, commands, _ = flown
    reason = spread_reason(setup, nominal, least(commands), none_lost)
    half = np.median(np.sort(commands)[:LOSSES])
    assert reason.startswith(
        "4.7 % of the vehicles that the airframe's ranges allow are lost (small steps in a light breeze: 12 of 256; 0 of 256 with "
        "the vehicle in their middle): give the hover command, or identify the vehicle from a log"
    )
    assert reason.endswith(f"in half of those lost the hover command is below {half:.3g}, in the middle 0.554")


def test_lost_vehicles_of_long_lags_are_named_with_it(flown):
    setup, nominal, _, lags = flown
    reason = spread_reason(setup, nominal, ~least(lags, FLIGHTS - LOSSES), none_lost)
    half = np.median(np.sort(lags)[-LOSSES:])
    assert reason.endswith(
        f": identify the vehicle from a log; in half of those lost the rotor lag is above {half:.3g} s, in the middle 0.02 s"
    )


def test_losses_that_the_middle_has_too_do_not_come_from_the_ranges(flown):
    setup, nominal, commands, _ = flown
    assert spread_reason(setup, nominal, least(commands), lambda _: least(commands)) == ""


def test_few_losses_need_no_other_flights(flown):
    setup, nominal, commands, _ = flown

    def refuse(_):
        pytest.fail("flown though no loss needs it")

    assert spread_reason(setup, nominal, least(commands, 2), refuse) == ""


def test_losses_of_an_identified_airframe_do_not_come_from_wide_ranges(flown):
    """All numbers within 5 %: the vehicles are known, and gains that lose them are at fault."""
    setup, nominal, commands, _ = flown
    wide = setup.spec.uncertainty
    narrow = Uncertainty(wide.names, (0.05,) * len(wide.names), wide.correlation)
    known = replace(setup, spec=replace(setup.spec, uncertainty=narrow))
    assert spread_reason(known, nominal, least(commands), none_lost) == ""


@pytest.fixture
def judge_losses(tmp_path, monkeypatch):
    """Return a judge of first flights that lose a number of vehicles of an airframe's ranges, and none of those in the middle."""

    def judged(losses, airframe):
        def fly(setups, *_):
            flights = len(setups[0].draws[1])
            scores = np.ones((len(setups), len(setups[0].metrics), flights))
            scores[:, 0] = [np.arange(flights) < (losses if is_drawn_first_flight(setup) else 0) for setup in setups]
            return scores

        monkeypatch.setattr(assessing, "fly", fly)
        return tuner.judge(write(tmp_path, PX4), airframe=airframe)

    def is_drawn_first_flight(setup):
        return setup.spec.uncertainty and setup.spec.name == "small steps in a light breeze"

    estimated = replace(load("f450"), uncertainty=uncertainty(hover=False))
    monkeypatch.setattr("tuner.extensions.judge.vehicle_files.load", lambda *_, **__: estimated)
    return judged


def test_a_parts_list_whose_ends_are_lost_is_not_judged(judge_losses):
    opinion = judge_losses(LOSSES, "f450")
    assert opinion.verdict == "not judged" and opinion.exit_code == 3
    assert opinion.document.sentence.startswith(
        "Not judged: 4.7 % of the vehicles that the airframe's ranges allow are lost (small steps in a light breeze: 12 of 256"
    )
    assert opinion.document.lost_after.events == LOSSES


def test_a_class_whose_ends_are_lost_has_a_reason(judge_losses):
    opinion = judge_losses(LOSSES, None)
    assert opinion.verdict == "no objection" and opinion.document.reasons[0].startswith("4.7 % of the vehicles")


def test_a_parts_list_of_which_most_are_lost_is_refused(judge_losses):
    opinion = judge_losses(200, "f450")
    assert opinion.verdict == "do not fly" and "flights are lost" in opinion.document.reasons[0]


def test_few_lost_vehicles_of_a_parts_list_are_judged(judge_losses):
    assert judge_losses(2, "f450").verdict == "no objection"
