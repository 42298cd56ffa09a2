"""Numbers of the page: those of `fly`, `margins` and `compare`, to the last digit printed."""

import numpy as np
import pytest

import tuner
from objectives.margins.quantities import QUANTITIES
from plant.errors import InputError
from tests.tuner.extensions.studio.conftest import STUDIES
from tuner.documents.parts import in_shown_units, row_in_degrees
from tuner.extensions.studio.answering import Bench, answer
from tuner.extensions.studio.messages import read_request
from tuner.extensions.studio.session import open_session, with_pins
from tuner.text.numbers import significant
from tuner.text.units import in_degrees

HAND = {"angle.kp": 8.0, "angle.ki": 12.0, "angle.kd": 0.12}


def request_of(bench, values=HAND, **others):
    return read_request(bench.session, bench.loops.channels, {"number": 1, "values": values, **others})


@pytest.fixture(scope="module")
def by_hand(motor):
    """Gains of the Python API at the setting, and the study."""
    bench, _ = motor
    return tuner.read_gains(bench.session.study.path).replace(HAND), bench.session.study


def test_objectives_are_those_of_fly(bench, by_hand):
    gains, study = by_hand
    flown = tuner.fly(gains, study=study, flights=16)
    rows = {row["label"]: row for row in answer(bench, request_of(bench), 16)["rows"]}
    for metric in ("itae.angle", "travel"):
        value, unit = flown.table.loc[metric, ["mean", "unit"]]
        # Sums of other layouts differ in the last bit.
        assert rows[f"mean({metric})"]["value"] == pytest.approx(value * in_degrees(unit).factor, rel=1e-14)


@pytest.mark.parametrize("flights", [16, 64])
def test_responses_are_those_of_fly(bench, by_hand, flights):
    gains, study = by_hand
    flown = tuner.fly(gains, study=study, flights=flights).recorded
    mine = bench.flights.responses(request_of(bench).settings[0].row, 0, flights)
    assert np.array_equal(flown.actual, mine.actual) and np.array_equal(flown.time, mine.time)


def test_margins_are_those_of_margins(bench, by_hand):
    gains, study = by_hand
    document = tuner.margins(gains, study=study).document
    made = answer(bench, request_of(bench), 256)
    shown = {row["name"]: row["cells"] for row in made["loops"]["rows"]}
    for name in ("ms", "phase_margin", "gain_up"):
        value = document.channels[0].quantities[name].value
        quantity = QUANTITIES[name]
        assert shown[quantity.label] == [significant(float(quantity.shown(value)))]
    ms = next(row for row in made["rows"] if row["label"] == "ms")
    assert ms["value"] == document.requirements[0].value
    assert ms["verdict"]["word"] == ("kept" if document.passed else "broken")


def test_the_worst_amplitudes_curve_touches_the_peak_of_sensitivity(bench, by_hand):
    gains, study = by_hand
    ms = tuner.margins(gains, study=study).document.channels[0].quantities["ms"].value
    assert ms is not None
    loop = bench.loops.curve(request_of(bench).settings[0], "angle").response
    # A grid of 300 frequencies misses the peak by little and never exceeds it.
    assert 0.99 * ms < float(np.max(1.0 / np.abs(1.0 + loop))) <= ms * (1.0 + 1e-9)


def test_more_flights_narrow_the_intervals_and_reuse_the_first(bench):
    widths = []
    for flights in (16, 64, 256):
        row = answer(bench, request_of(bench), flights)["rows"][1]
        low, high = (float(text.replace("−", "-")) for text in row["here"][1].strip("[]").split(", "))
        widths.append(high - low)
    assert widths[0] > widths[1] > widths[2] > 0.0
    before = bench.flights.problem.flights_made
    answer(bench, request_of(bench), 256)
    assert bench.flights.problem.flights_made == before


def test_the_default_differs_from_itself_by_nothing(bench):
    default = bench.session.values(bench.session.default.row)
    rows = answer(bench, request_of(bench, default), 16)["rows"]
    assert all(row["here"] == row["others"][0] for row in rows)
    assert rows[0]["changes"][0][0] == "0"


def test_pins_are_compared_and_drawn(bench):
    pins = [{"name": "slow <b>", "values": {"angle.kp": 5.0}}, {"name": "", "values": {}}]
    made = answer(bench, request_of(bench, pins=pins), 64)
    assert [other["name"] for other in made["others"]] == ["default", "slow <b>", "pin 2"]
    names = {trace["meta"].get("layer") for trace in made["charts"]["response-0"]["traces"]}
    assert {"here", "default", "pin1", "pin2"} <= names


def test_an_unstable_loop_is_shown(bench):
    made = answer(bench, request_of(bench, {"angle.kp": 60.0, "angle.ki": 200.0, "angle.kd": 0.01}), 256)
    assert made["loops"]["rows"][0]["cells"] == ["NO"]
    assert "Violates" in made["summary"] and "peak sensitivity Ms" in made["summary"]


def test_the_first_stage_has_the_limits_of_the_model_that_later_ones_have(bench):
    first, later = (
        {
            row["label"]: (row["here"], row["others"][0], row["verdict"])
            for row in answer(bench, request_of(bench), flights)["rows"]
            if row["kind"] == "requirement"
        }
        for flights in (16, 64)
    )
    assert first == later and first


def test_gains_of_a_file_keep_what_is_not_searched(bench, tmp_path):
    study = bench.session.study
    gains = tuner.read_gains(study.path).replace({"angle.kp": 21.0, "angle.t_f": 0.002})
    session = open_session(gains.write(tmp_path / "mine.json"), study.path)
    assert session.values(session.start.row)["angle.kp"] == 21.0
    assert session.gains(session.row({"angle.kp": 30.0}))["angle.t_f"] == 0.002


@pytest.mark.slow
def test_numbers_of_a_quadrotor_are_those_of_fly_and_margins():
    session = open_session(STUDIES / "quickstart.toml")
    bench = Bench.of(session, 2)
    setting = {**session.values(session.start.row), "attitude.k2": 8.0, "position.omega_c": 2.0}
    made = answer(bench, read_request(session, bench.loops.channels, {"number": 1, "values": setting}), 256)
    gains, study = session.gains(session.row(setting)), session.study
    rows = {row["label"]: row for row in made["rows"]}
    flown = tuner.fly(gains, study=study, flights=256)
    assert rows["mean(travel)"]["value"] == pytest.approx(float(flown.table.loc["travel", "mean"]), rel=1e-14)
    document = tuner.margins(gains, study=study).document
    assert len(document.requirements) == 4
    for row in document.requirements:
        mine, shown = rows[row.label], in_shown_units(row)
        assert mine["here"] == [
            significant(row_in_degrees(row, "value").value if shown.unit == row.unit else shown.value)
        ]
        assert mine["state"] == row.state
        assert mine["verdict"]["word"] == ("kept" if row.is_satisfied else "broken")
    yaw = [channel.channel for channel in document.channels].index("yaw")
    shown = {row["name"]: row["cells"][yaw] for row in made["loops"]["rows"]}
    peak = document.channels[yaw].quantities["ms"].value
    assert peak is not None and shown["peak sensitivity Ms"] == significant(peak)


def test_the_default_of_columns_that_one_gain_moves_is_the_default():
    """Betaflight's p is 45 for roll and 47 for pitch: the page opens with these, and a move sets both."""
    session = open_session(STUDIES / "betaflight.toml")
    values = session.values(session.default.row)
    assert np.array_equal(session.row(values), session.default.row)
    name = "tilt.p"
    (columns,) = (
        columns
        for variable, columns in zip(session.study.space.variables, session.study.space.columns, strict=True)
        if variable.name == name
    )
    assert len(set(session.default.row[list(columns)])) > 1
    assert set(session.row({**values, name: 50.0})[list(columns)]) == {50.0}


def test_gains_of_files_open_as_pins(bench, tmp_path):
    study = bench.session.study
    gains = tuner.read_gains(study.path)
    session = with_pins(open_session(study.path), [gains.replace({"angle.kp": 21.0}).write(tmp_path / "other.json")])
    (pin,) = session.pins
    assert (pin.name, pin.key, session.values(pin.row)["angle.kp"]) == ("other", "pin1", 21.0)
    fixed = gains.replace({"angle.t_f": 0.002}).write(tmp_path / "fixed.json")
    with pytest.raises(InputError, match="does not search"):
        with_pins(session, [fixed])
    with pytest.raises(InputError, match="given 5 files; allowed: at most 4"):
        with_pins(session, [fixed] * 5)
