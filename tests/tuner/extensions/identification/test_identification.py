"""A vehicle out of logs of flights whose numbers are known, and of a real one that others have identified."""

from dataclasses import replace

import numpy as np
import pytest

import tuner
from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.schema import Sourced
from tests.tuner.conftest import QUICKSTART
from tests.tuner.extensions.identification.conftest import CRAZYFLIE
from tests.tuner.extensions.identification.known_flights import (
    AIRFRAME,
    AXES,
    GYRO,
    PRIOR,
    known_flights,
    misses,
    truth_of,
)
from tuner.api.gains import default_gains
from tuner.extensions.identification.api import check_logs, refusals_of
from tuner.extensions.identification.building import identification_document, verdict
from tuner.extensions.identification.checks import check_flight, is_silent
from tuner.extensions.identification.identify import identify_vehicle, resample_segments
from tuner.extensions.identification.onward import identified_text, identified_values, uncertainty_of
from tuner.extensions.identification.white_noise import gyro_density, gyro_noise
from tuner.extensions.logs.csv_writing import MAPPING, csv_table
from tuner.extensions.vehicle_fit import fit
from tuner.extensions.vehicle_fit.flights import flights_of, longest_flight
from tuner.extensions.vehicle_fit.identifiability import GIVEN, OF_OUTPUT, wider_than_prior
from tuner.extensions.vehicle_fit.parameters import EarlierPosterior, space_of
from tuner.extensions.vehicle_fit.prediction import settled_masks
from tuner.extensions.vehicle_fit.regression import initial_estimate

FRD = np.array([1.0, -1.0, -1.0])


@pytest.fixture
def fitted_once(monkeypatch):
    """Fit with the noise of the start alone, where it does not count how close the fit comes; it takes a third of the time."""
    monkeypatch.setattr(fit, "MAX_NOISE_FITS", 1)


def test_the_truth_lies_within_the_intervals(flights, identified):
    found = np.array([list(misses(*pair).values()) for pair in zip(identified, flights, strict=True)])
    # 30 distances of unit size: none beyond 4, and hardly more than a tenth beyond the 95 % interval.
    assert np.abs(found).max() < 4.0
    assert np.mean(np.abs(found) > 1.96) < 0.14


def test_a_fit_is_the_optimum_under_the_noise_that_it_leaves(flights):
    """Residuals of the start are larger and of another colour: one fit under their noise ends half a deviation away."""
    samples = resample_segments([flights[0].log.between(0.0, 5.0)])
    space = space_of(AIRFRAME.vehicle, ["1"])
    problem = fit.Problem(space, AIRFRAME.vehicle, samples, settled_masks(samples))
    free = np.array([name not in GIVEN for name in space.names])
    start = initial_estimate(space, samples, AIRFRAME.vehicle)
    found = fit.fit_parameters(problem, start, free)
    std = np.sqrt(np.diag(found.covariance))
    once = fit.fit_with_noise(problem, start, free, fit.noise_of(problem, start))
    assert np.abs((once.estimate - found.estimate) / std).max() > 0.2
    again = fit.fit_with_noise(problem, found.estimate, free, found.noise)
    np.testing.assert_allclose((again.estimate - found.estimate) / std, 0.0, atol=0.05)


def test_intervals_are_narrower_than_the_prior_and_the_given_stays(identified):
    for found in identified:
        ratio = dict(
            zip(found.space.names, np.sqrt(np.diag(found.fit.covariance)) / found.space.prior_std, strict=True)
        )
        assert max(ratio[name] for name in ("inertia.x", "inertia.y", "lag_up", "lag_down")) < 0.4
        assert set(GIVEN) <= set(found.reasons)
        assert [ratio[name] for name in GIVEN] == pytest.approx([1.0] * len(GIVEN))


def test_the_two_regressions_lie_on_both_sides_and_further_away(flights, identified):
    ratios = []
    for flight, found in zip(flights, identified, strict=True):
        truth = flight.vehicle.inertia
        ours = found.space.numbers(found.fit.estimate).inertia
        for k in range(2):
            high, low = (value / truth[k] for value in found.regressions[k])
            ratios.append((abs(np.log(ours[k] / truth[k])), np.log(high / low)))
    ours, apart = np.mean(ratios, axis=0)
    assert apart > ours


def test_what_is_predicted_was_kept_from_the_fit_and_is_predicted_well(identified):
    for found in identified:
        assert np.all(found.windows.explained[:2] > 0.7)
        kept = np.concatenate(
            [part.time[mask == 0.0] for part, mask in zip(found.problem.samples, found.problem.masks, strict=True)]
        )
        assert set(found.windows.time.ravel().tolist()) <= set(kept.tolist())


def test_axes_that_are_not_excited_are_named_and_stay_at_the_prior(flown, fitted_once):
    found = identify_vehicle([flown[2].log], AIRFRAME)
    for name in (*OF_OUTPUT["pitch"], *OF_OUTPUT["yaw"]):
        at = found.space.names.index(name)
        assert name in found.reasons
        assert found.fit.estimate[at] == found.space.center[at]
    assert "inertia.x" not in found.reasons


@pytest.mark.slow
def test_coverage_of_95_per_cent_intervals_over_200_logs():
    found = []
    for flight in known_flights(200, duration=16.0, seed=1):
        found.append(list(misses(identify_vehicle([flight.log], AIRFRAME), flight).values()))
    assert 0.93 <= np.mean(np.abs(found) < 1.96) <= 0.97


@pytest.mark.slow
def test_no_log_without_excitation_on_an_axis_is_taken_for_one_with_it():
    for flight in known_flights(100, duration=8.0, seed=3, excited=("roll", "lift")):
        reasons = identify_vehicle([flight.log], AIRFRAME).reasons
        assert {"inertia.y", "inertia_share", "torque_ratio"} <= set(reasons)


def test_a_flight_of_a_crazyflie_gives_what_others_found(crazyflie):
    """Eschmann and others print 1.029e-5 and 1.105e-5 kg m2 of the whole flight; a fit of our own data's first reader 1.095e-5 and
    1.171e-5, with a lag of 0.075 s, the same up and down.
    """
    document = identification_document(crazyflie, [], None)
    numbers = {row.name: row for row in document.numbers}
    for name, printed in (("inertia.x", 1.029e-5), ("inertia.y", 1.105e-5)):
        assert numbers[name].low < printed < numbers[name].high
        assert numbers[name].high / numbers[name].low < 1.35
    assert 0.06 < 0.5 * (numbers["lag_up"].value + numbers["lag_down"].value) < 0.09
    roll, *_ = document.prediction
    assert roll.output == "roll" and roll.explained > 0.9


def test_yaw_that_no_body_can_have_is_left_at_the_prior(crazyflie):
    assert set(OF_OUTPUT["yaw"]) <= set(crazyflie.reasons)
    assert not crazyflie.problem.outputs[2]


def test_the_airframe_file_holds_the_numbers_and_the_set(crazyflie, tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(identified_text(crazyflie, "A Crazyflie"))
    read, numbers = load(file), crazyflie.space.numbers(crazyflie.fit.estimate)
    assert read.uncertainty == uncertainty_of(crazyflie)
    assert read.vehicle.inertia == pytest.approx(numbers.inertia, rel=1e-4)
    assert "log15_70_to_85" in read.sources["inertia.x"].source
    assert read.sources["mass"] == load("crazyflie-pybullet").sources["mass"]
    assert read.uncertainty is not None
    at = {name: k for k, name in enumerate(read.uncertainty.names)}
    # Both inertias follow from the same thrust, arm and mass.
    assert read.uncertainty.correlation[at["inertia.x"]][at["inertia.y"]] > 0.8
    assert read.uncertainty.correlation[at["mass"]][at["inertia.x"]] > 0.3


def test_a_written_file_that_studies_refuse_is_announced(crazyflie, tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(identified_text(crazyflie, "A Crazyflie"))
    assert refusals_of(file) == []
    text = file.read_text()
    speed = load(file).vehicle.speed_max
    file.write_text(text.replace(f"speed_max = {{ value = {speed!r}", f"speed_max = {{ value = {3.0 * speed!r}"))
    (said,) = refusals_of(file)
    assert said.startswith("mine.toml was written, but studies refuse it as it stands: ")
    assert "thrust to weight" in said and "allow_unphysical = true twice" in said
    file.write_text("allow_unphysical = true\n" + file.read_text())
    assert default_gains("pid", airframe=file).quadrotor("").airframe.vehicle.speed_max == pytest.approx(3.0 * speed)
    assert check_logs(CRAZYFLIE, airframe=file).document.airframe == "mine"


@pytest.mark.parametrize(("dead_time", "is_noted"), [(-0.05, True), (-1e-9, False), (0.05, False)])
def test_a_negative_dead_time_is_explained(crazyflie, dead_time, is_noted):
    estimate = crazyflie.fit.estimate.copy()
    estimate[crazyflie.space.names.index("dead_time")] = dead_time
    said = verdict(replace(crazyflie, fit=replace(crazyflie.fit, estimate=estimate)))
    assert ("dead_time is negative, -50 ms" in said) is is_noted


def test_a_dead_time_goes_into_the_file_where_the_log_tells_it(crazyflie, tmp_path):
    prior = crazyflie.airframe
    late = replace(prior, sources=prior.sources | {"dead_time": Sourced(0.002, "s", "measured")})
    file = tmp_path / "mine.toml"
    file.write_text(identified_text(replace(crazyflie, airframe=late), "A Crazyflie"))
    numbers = crazyflie.space.numbers(crazyflie.fit.estimate)
    assert load(file).vehicle.dead_time == pytest.approx(numbers.dead_time, rel=1e-4)
    assert "controller.delay ends at the logged command" in load(file).sources["dead_time"].source
    untold = replace(crazyflie, airframe=late, reasons=crazyflie.reasons | {"dead_time": "hardly narrower"})
    file.write_text(identified_text(untold, "A Crazyflie"))
    assert load(file).vehicle.dead_time == 0.002


@pytest.mark.slow
def test_two_logs_narrow_what_one_leaves(halves):
    """The same vehicle flown twice: the same log under another name would be told from it by nothing."""
    flight, one, both = halves.flight, halves.first, halves.both
    assert len(both.problem.samples) == 2
    spread = [np.sqrt(np.diag(found.fit.covariance))[found.space.names.index("lag_up")] for found in (one, both)]
    assert spread[1] < spread[0]
    assert np.abs(list(misses(both, flight).values())).max() < 4.0


@pytest.mark.slow
def test_a_second_log_on_top_of_the_first_tells_what_both_at_once_tell(halves):
    """To one standard deviation, for the noise of each is fitted anew; intervals as wide to a third in the middle.

    Halves of 9 s: of 4.5 s too few blocks are fitted, so that one width of twelve differed by 0.83.
    """
    first, both, second = halves.first, halves.both, halves.second
    left = set(both.reasons) | set(second.reasons)
    # Where the gyro's low-pass is identified by one alone, the split of the delay widens the lags of the other alone.
    if "gyro_delay" in set(both.reasons) ^ set(second.reasons):
        left |= {"lag_up", "lag_down"}
    told = [k for k, name in enumerate(first.space.names[: first.space.physical]) if name not in left]
    # A number at the edge may be told by the one and not by the other.
    assert len(told) > 8 and len(set(both.reasons) ^ set(second.reasons)) < 2
    wide, narrow, same = (np.sqrt(np.diag(found.fit.covariance))[told] for found in (first, second, both))
    assert np.all(np.abs(second.fit.estimate[told] - both.fit.estimate[told]) < same)
    apart = np.abs(narrow / same - 1.0)
    assert np.median(apart) < 0.35 and apart.max() < 0.7 and np.mean(wide / same) > 1.15


def test_what_the_first_log_told_stays_told_where_the_second_is_silent(flown, identified, fitted_once):
    first = identified[0]
    n = first.space.physical
    known = EarlierPosterior(
        first.space.names[:n], first.fit.estimate[:n], first.fit.covariance[:n, :n], first.space.initial_std[:n]
    )
    second = identify_vehicle([flown[2].log], AIRFRAME, earlier=known)
    at = first.space.names.index("inertia.y")
    assert "inertia.y" not in second.reasons
    assert second.fit.estimate[at] == pytest.approx(first.fit.estimate[at])
    assert identified_values(second, ())["inertia.y"].value == pytest.approx(
        identified_values(first, ())["inertia.y"].value, rel=1e-4
    )


def test_the_noise_of_the_gyro_is_that_of_the_sensor(flights):
    assert gyro_noise([flight.log for flight in flights]) == pytest.approx([GYRO] * 3, rel=0.05)


def test_a_study_flies_the_noise_of_the_logged_gyro(flights, identified, tmp_path):
    """Of the true density, at the study's own rate; a rate that the study gives stands."""
    file = tmp_path / "mine.toml"
    file.write_text(identified_text(identified[0], "A vehicle"))
    log = flights[0].log
    assert load(file).gyro_noise == pytest.approx(GYRO * np.sqrt(2.0 / log.rate), rel=0.05)
    assert load(file).gyro_noise == pytest.approx(gyro_density([log]), rel=1e-4)
    text = QUICKSTART.read_text(encoding="utf-8").replace('name = "hummingbird"', 'file = "mine.toml"')
    (tmp_path / "mine_study.toml").write_text(text)
    study = tuner.load_study(tmp_path / "mine_study.toml", kind=tuner.Study)
    rate = study.system.timing.control_period**-1
    assert study.scenarios[0].spec.sensors.rate == pytest.approx(load(file).gyro_noise * np.sqrt(0.5 * rate))
    given = tuner.load_study(study.path, {"scenario.0.sensors.rate": 0.02}, kind=tuner.Study)
    assert given.scenarios[0].spec.sensors.rate == 0.02


def test_a_log_without_flight_is_refused(flights):
    log = replace(flights[0].log, command=0.1 * flights[0].log.command)
    with pytest.raises(InputError, match="holds no flight of 4 s"):
        flights_of(log, AIRFRAME)


def hopped(log, lengths):
    """The log flown for so many seconds at a time [s], with 3 s on the ground before, between and after."""
    time, up, clock = [], [], 0.0
    for length in [0.0, *lengths]:
        for airborne_now, span in ((True, length), (False, 3.0)):
            count = round(span / log.period)
            time += [clock + k * log.period for k in range(count)]
            up += [airborne_now] * count
            clock += count * log.period
    rows = np.arange(len(time)) % len(log.time)
    command = np.where(np.array(up)[:, None], log.command[rows], 0.05)
    return replace(log, time=np.array(time), gyro=log.gyro[rows], acceleration=log.acceleration[rows], command=command)


def test_all_flights_of_a_log_that_are_long_enough_count(flights):
    log = hopped(flights[0].log, (9.0, 12.0, 5.0))
    first, second = flights_of(log, AIRFRAME)
    assert first.time[-1] < second.time[0] and 4.0 < first.duration < 6.0 and 7.0 < second.duration < 9.0
    assert first.notes == ("holds three flights; too short to use are those of 5.1 s",) and not second.notes
    assert not flights_of(flights[0].log, AIRFRAME)[0].notes


def test_the_longest_flight_of_a_log_is_named_and_so_are_the_others(flights):
    log = longest_flight(hopped(flights[0].log, (9.0, 12.0)), AIRFRAME)
    (said,) = [text for text in log.notes if "flights" in text]
    assert "2 flights" in said and "the longest is used" in said and "@BEGIN:END" in said
    assert f"from {log.time[0]:.1f} to {log.time[-1]:.1f} s" in said and 7.0 < log.duration < 9.0
    assert any("the longest is used" in finding.text for finding in check_flight(log, AIRFRAME))
    assert not longest_flight(flights[0].log, AIRFRAME).notes


def test_flights_that_are_too_short_are_refused_with_their_lengths(flights):
    with pytest.raises(
        InputError, match=r"two flights, of \d\.\d and \d\.\d s, of which 2 s at take-off and at landing"
    ) as refused:
        flights_of(hopped(flights[0].log, (6.5, 5.0)), AIRFRAME)
    assert "below 50 %" not in str(refused.value)


def test_a_number_wider_than_its_prior_is_not_identified(identified):
    found = identified[0]
    free = np.array([name not in found.reasons for name in found.space.names])
    assert wider_than_prior(found.fit, free) == {}
    k = found.space.names.index("lag_up")
    wide = found.fit.covariance.copy()
    wide[k, k] = (1.3 * found.space.initial_std[k]) ** 2
    assert wider_than_prior(replace(found.fit, covariance=wide), free) == {
        "lag_up": "its interval is 130 % of the prior's: no better known than before"
    }


def test_the_verdict_asks_to_weigh_the_vehicle(identified):
    assert "Weigh the vehicle" in verdict(identified[0])


FAULTS = {
    "front motors swapped": (lambda log: replace(log, command=log.command[:, [1, 0, 2, 3]]), "front right, front left"),
    "order of the Crazyflie": (lambda log: replace(log, command=log.command[:, [1, 3, 2, 0]]), "four motors act as"),
    "FRD": (lambda log: replace(log, gyro=log.gyro * FRD, acceleration=log.acceleration * FRD), "z points down"),
    "gyro in FRD": (lambda log: replace(log, gyro=log.gyro * FRD), "turn against the motors"),
    "g": (lambda log: replace(log, acceleration=log.acceleration / 9.80665), "values are in g, not m/s2"),
    "m/s2 as g": (lambda log: replace(log, acceleration=log.acceleration * 9.80665), "values are in m/s2, not g"),
    "deg/s": (lambda log: replace(log, gyro=np.degrees(log.gyro)), "values are in deg/s, not rad/s"),
    "rad/s as deg/s": (lambda log: replace(log, gyro=np.radians(log.gyro)), "values are in rad/s, not deg/s"),
    "gyro twice": (lambda log: replace(log, gyro=2.0 * log.gyro), "the time base is wrong, often by 2"),
    "time twice": (lambda log: replace(log, time=2.0 * log.time), "the time base is wrong, often by 2"),
    "commands in per cent": (lambda log: replace(log, command=100.0 * log.command), "correct idle and full"),
    "a motor stands still": (
        lambda log: replace(log, command=log.command * [1.0, 0.0, 1.0, 1.0]),
        "front right never change",
    ),
    "slow": (lambda log: log.where(np.arange(len(log.time)) % 16 == 0), "samples a second are too few"),
    "lossy": (lambda log: log.where(np.random.default_rng(1).random(len(log.time)) > 0.1), "are lost"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_a_log_are_found_from_physics(fault, flights):
    spoil, message = FAULTS[fault]
    # The prior is the vehicle itself, so that factors are those of the fault.
    airframe = replace(AIRFRAME, vehicle=flights[0].vehicle)
    assert any(message in finding.text for finding in check_flight(spoil(flights[0].log), airframe))


def test_a_good_log_has_no_faults(flights):
    for flight in flights:
        assert not check_flight(flight.log, replace(AIRFRAME, vehicle=flight.vehicle))


def test_a_calm_log_is_told_to_be_flown_with_more_excitation(flown):
    flight = flown[3]
    assert any("hardly follow the motors" in finding.text for finding in check_flight(flight.log, AIRFRAME))


def saturated(log):
    """The log at 100 Hz with one motor at full command for a tenth of the time."""
    slow = log.where(np.arange(len(log.time)) % 5 == 0)
    full = (np.arange(len(slow.time)) % 10 == 0)[:, None] & (np.arange(4) == 2)
    return replace(slow, command=np.where(full, 1.0, slow.command))


def test_a_log_that_tells_nothing_is_refused_by_check_and_fit_alike(flown, fitted_once, tmp_path):
    """It was called usable, and the fit ended in an IndexError."""
    calm, mapping = saturated(flown[3].log), tmp_path / "columns.toml"
    with pytest.raises(InputError, match="do not identify the vehicle"):
        identify_vehicle([calm], AIRFRAME)
    mapping.write_text(MAPPING)
    for name, log in (("calm.csv", calm), ("shaken.csv", flown[0].log)):
        (tmp_path / name).write_text(csv_table(log))
    checked = check_logs(tmp_path / "calm.csv", airframe="crazyflie-pybullet", mapping=mapping)
    assert not checked.usable
    assert any("do not identify the vehicle" in row.text for row in checked.document.findings)
    both = [tmp_path / "calm.csv", tmp_path / "shaken.csv"]
    checked = check_logs(both, airframe="crazyflie-pybullet", mapping=mapping)
    assert checked.usable and any("do not identify the vehicle" in row.text for row in checked.document.findings)
    assert is_silent(calm) and not any(is_silent(flight.log) for flight in flown[:3])


def test_a_curve_with_a_node_that_is_no_better_known_is_not_identified(identified):
    assert all(row.identified for row in identification_document(identified[0], [], None).curve)
    wide = replace(identified[0], wider={"thrust.65": "its interval is 110 % of the prior's"})
    assert not any(row.identified for row in identification_document(wide, [], None).curve)


def test_the_truth_of_a_flight_has_the_names_of_the_coordinates(flights, identified):
    # These flights have no low-pass in their gyro, whose delay is positive.
    assert {*truth_of(flights[0]), "gyro_delay"} == set(identified[0].space.names[: identified[0].space.physical])
    assert set(AXES) == set(OF_OUTPUT) and PRIOR.mass == AIRFRAME.vehicle.mass
