"""Two logs side by side: measures with a closed form, the filter of the flights' own metric, and what intervals promise."""

from dataclasses import replace

import numpy as np
import pytest

from objectives.metrics import METRICS, noise
from plant.errors import InputError
from plant.quadrotor.airframes import load
from tuner.extensions.identification.checks import check_flight
from tuner.extensions.log_comparison.comparison import MEASURES, Spread, measured, ratio_of
from tuner.extensions.logs.flight_log import FlightLog

PERIOD = 0.002


def log_of(draw, seconds=20.0, size=1.0):
    """A hovering log of white noise, `size` times as large."""
    count = round(seconds / PERIOD)
    command = np.sqrt(0.4 * (1.0 + 0.05 * size * draw.normal(size=(count, 4))))
    force = size * draw.normal(size=(count, 3)) + [0.0, 0.0, 9.81]
    return FlightLog(
        "made", "made", "", PERIOD * np.arange(float(count)), size * draw.normal(size=(count, 3)), force, command
    )


def test_noise_is_the_metric_of_the_flights():
    log = log_of(np.random.default_rng(1), 8.0)
    thrust = log.command**2 / np.mean(log.command**2)
    squares = []
    for column in thrust.T:
        kept = noise.start(column[0])
        for value in column:
            kept = noise.update(kept, value, PERIOD)
        squares.append(kept.squares)
    assert measured(log)["noise"].value == pytest.approx(np.sqrt(np.mean(squares) / len(thrust)), rel=2e-3)


def test_travel_is_how_far_commands_move_and_rates_are_root_mean_squares():
    time = PERIOD * np.arange(5000.0)
    swing = np.sin(2.0 * np.pi * 5.0 * time)[:, None]
    # Up and down once a period: 4 amplitudes, of 4 rotors, 5 times a second.
    log = FlightLog(
        "made",
        "made",
        "",
        time,
        swing * [1.0, 2.0, 3.0],
        swing * [0.0, 0.0, 1.0],
        np.sqrt(0.5 + 0.1 * swing.repeat(4, 1)),
    )
    found = measured(log)
    assert found["travel"].value == pytest.approx(4 * 4 * 0.2 * 5, rel=2e-3)
    assert [found[f"rate.{axis}"].value for axis in ("roll", "pitch", "yaw")] == pytest.approx(
        np.array([1.0, 2.0, 3.0]) / np.sqrt(2.0), rel=1e-3
    )
    assert found["lift"].value == pytest.approx(np.sqrt(0.5), rel=1e-3)


def test_the_interval_of_a_ratio_holds_the_truth_in_19_of_20_pairs():
    draw, held = np.random.default_rng(2), []
    for _ in range(60):
        before, after = measured(log_of(draw, 8.0)), measured(log_of(draw, 8.0, 1.1))
        for name in ("rate.roll", "rate.pitch", "rate.yaw", "lift"):
            ratio, low, high = ratio_of(after[name], before[name])
            assert low < ratio < high
            held.append(low <= 1.1 <= high)
    assert 0.91 < np.mean(held) <= 1.0


def test_the_relative_error_of_a_root_mean_square_is_that_of_its_samples():
    """Of n normal samples it is 1/sqrt(2 n), half of that of the mean square; of travel, no root, it is what scatters."""
    draw, logs = np.random.default_rng(6), []
    for _ in range(30):
        logs.append(measured(log_of(draw, 12.0)))
    for name in ("rate.roll", "rate.pitch", "rate.yaw", "lift"):
        mean = np.sqrt(np.mean([log[name].relative ** 2 for log in logs]))
        assert mean == pytest.approx(1.0 / np.sqrt(2.0 * 6000.0), rel=0.2)
    travels = np.array([log["travel"].value for log in logs])
    mean = np.sqrt(np.mean([log["travel"].relative ** 2 for log in logs]))
    assert mean == pytest.approx(np.std(np.log(travels), ddof=1), rel=0.45)


def test_the_interval_of_a_short_and_a_long_log_is_that_of_the_short_ones_few_blocks():
    """Six normal blocks against a log that is known: with the degrees of freedom of the latter it would hold in 89 %."""
    draw, known = np.random.default_rng(7), Spread(1.0, 1.0, 1.0, 0.0, 10_000)
    blocks = 1.0 + 1e-4 * draw.standard_normal((4000, 6))
    errors = blocks.std(axis=1, ddof=1) / np.sqrt(6.0)
    held = [
        low <= 1.0 <= high
        for mean, error in zip(blocks.mean(axis=1), errors, strict=True)
        for _, low, high in (
            ratio_of(Spread(mean, mean, mean, error, 6), known),
            ratio_of(known, Spread(mean, mean, mean, error, 6)),
        )
    ]
    assert np.mean(held) == pytest.approx(0.95, abs=0.012)


def test_an_offset_of_the_sensors_is_no_motion():
    log = log_of(np.random.default_rng(8), 8.0)
    moved = replace(log, gyro=log.gyro + [0.5, -0.3, 0.2], acceleration=log.acceleration + 0.4)
    before, after = measured(log), measured(moved)
    for name in ("rate.roll", "rate.pitch", "rate.yaw", "lift"):
        assert after[name] == pytest.approx(before[name])


def test_a_short_flight_is_refused():
    with pytest.raises(InputError, match="at least 6 s are compared"):
        measured(log_of(np.random.default_rng(3), 4.0))


def test_measures_that_are_metrics_have_their_names():
    assert {"noise", "travel"} <= set(METRICS) & set(MEASURES)


def test_a_pause_is_no_part_of_the_flight():
    """Blocks lie within what was logged, and nothing is a difference across the pause."""
    whole = log_of(np.random.default_rng(5), 10.0)
    early = whole.time < 5.0
    paused = replace(whole, time=np.where(early, whole.time, whole.time + 3.4))
    found = measured(paused)
    assert all(np.isfinite(spread).all() for spread in found.values())
    assert found["rate.roll"].value == pytest.approx(measured(whole)["rate.roll"].value, rel=0.01)
    with pytest.raises(InputError, match="without pauses"):
        measured(replace(whole, time=whole.time + 2.0 * np.floor(whole.time / 0.9)))


@pytest.mark.parametrize(("rate", "fatal"), [(49.0, True), (51.0, False)])
def test_a_log_of_less_than_50_samples_a_second_cannot_be_used(rate, fatal):
    log = log_of(np.random.default_rng(9), 4.0)
    slow = replace(log, time=np.arange(float(len(log.time))) / rate)
    told = [finding for finding in check_flight(slow, load("f450")) if "samples a second" in finding.text]
    assert [finding.fatal for finding in told] == [fatal]


@pytest.mark.parametrize(("gap", "parts"), [(0.2, 1), (0.3, 2)])
def test_a_pause_of_a_slow_log_is_longer_than_25_of_its_samples(gap, parts):
    """At 100 samples a second 0.25 s are a pause; 0.1 s would be a few samples that a card lost."""
    log = log_of(np.random.default_rng(10), 4.0)
    time = np.arange(float(len(log.time))) * 0.01
    late = np.where(time > time[len(time) // 2], time + gap - 0.01, time)
    assert len(replace(log, time=late).stretches()) == parts
