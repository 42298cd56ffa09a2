"""Frequency responses: against scipy's, known systems in noise, python-control, and betaflight-chirp-core on the same file."""

from dataclasses import replace
from typing import Any

import control as python_control
import numpy as np
import pytest
import scipy.signal

from plant.vectors import Vec3
from tests.tuner.extensions.identification.known_flights import AIRFRAME, PRIOR
from tests.tuner.extensions.logs.written import blackbox, truth
from tuner.extensions.identification.building import identification_document, response_rows
from tuner.extensions.identification.response_comparison import DECIBELS, compare_responses, difference_words
from tuner.extensions.identification.white_noise import gyro_noise, white_noise
from tuner.extensions.logs.reading import read_log
from tuner.extensions.vehicle_fit.frequency_response import Record, estimate_response
from tuner.extensions.vehicle_fit.model import actuator, lagging, low_passed, turning
from tuner.extensions.vehicle_fit.model_response import axis_commands, model_response, response_deviation
from tuner.extensions.vehicle_fit.parameters import space_of
from tuner.extensions.vehicle_fit.samples import LogSegment

# Their types are too narrow.
signal: Any = scipy.signal
control: Any = python_control
PERIOD, LENGTH, HIGHEST = 0.002, 1.0, 100.0
RATE = 1.0 / PERIOD
# A resonance at 30 Hz behind a sample of delay.
RESONANCE = signal.cont2discrete(([(60.0 * np.pi) ** 2], [1.0, 60.0, (60.0 * np.pi) ** 2]), PERIOD)
NUMERATOR, DENOMINATOR = np.ravel(RESONANCE[0]), np.ravel(RESONANCE[1])


def truth_at(frequency):
    return signal.freqz(NUMERATOR, DENOMINATOR, worN=frequency, fs=RATE)[1]


def record(draw, count, noise=0.0):
    """White noise through the system, with white noise on top."""
    u = draw.normal(size=count)
    y = signal.lfilter(NUMERATOR, DENOMINATOR, u) + noise * draw.normal(size=count)
    return Record(PERIOD, u, y, u)


def test_a_response_and_its_coherence_are_those_of_scipy():
    made = record(np.random.default_rng(1), 6000, noise=0.5)
    found = estimate_response([made], LENGTH, HIGHEST)
    assert found is not None
    how = {"fs": RATE, "window": "hann", "nperseg": 500}
    cross = signal.csd(made.input, made.output, **how)[1]
    ours = slice(1, 1 + len(found.frequency))
    assert found.frequency == pytest.approx(signal.welch(made.input, **how)[0][ours])
    assert found.response == pytest.approx((cross / signal.welch(made.input, **how)[1])[ours])
    assert found.coherence == pytest.approx(signal.coherence(made.input, made.output, **how)[1][ours])
    assert found.output_power == pytest.approx(signal.welch(made.output, **how)[1][ours])


def test_bands_hold_the_truth_at_their_share_and_two_records_count_as_both():
    draw, inside = np.random.default_rng(2), []
    for _ in range(60):
        found = estimate_response([record(draw, 3000, noise=1.0), record(draw, 3000, noise=1.0)], LENGTH, HIGHEST)
        assert found is not None and found.averages == pytest.approx(22.0 / (1.0 + 2.0 / 36.0 * 20.0 / 22.0))
        off = np.log(found.response / truth_at(found.frequency))
        power = np.abs(truth_at(found.frequency)) ** 2
        # To first order, so where the true coherence is not small.
        inside.append((np.abs([off.real, off.imag]) < found.half_width)[:, power / (power + 1.0) > 0.5])
    assert 0.93 < np.mean(inside) < 0.97


def closed_loop(draw, count):
    """The system in a loop with a gain of 0.3, noise of the sensor as large as the reference."""
    r, n = draw.normal(size=(2, count))
    loop = np.polyadd(DENOMINATOR, 0.3 * NUMERATOR)
    u = 0.3 * signal.lfilter(DENOMINATOR, loop, r - n)
    y = n + signal.lfilter(NUMERATOR, DENOMINATOR, u)
    return Record(PERIOD, u, y, r)


def test_feedback_biases_a_response_and_an_instrument_does_not():
    draw = np.random.default_rng(3)
    found = [closed_loop(draw, 30_000) for _ in range(4)]
    direct = estimate_response([entry._replace(instrument=entry.input) for entry in found], LENGTH, HIGHEST)
    measured = estimate_response(found, LENGTH, HIGHEST)
    assert direct is not None and measured is not None
    off = [np.log(part.response / truth_at(part.frequency)) for part in (direct, measured)]
    high = (direct.frequency > 40.0) & (direct.frequency < 60.0)
    # There noise turns the loop, and the response bends towards the inverse of the controller.
    bias = [np.abs(np.mean(part[high])) for part in off]
    assert bias[0] > 0.3 and bias[1] < 0.1

    inside = []
    for _ in range(30):
        measured = estimate_response([closed_loop(draw, 12_000)], LENGTH, 60.0)
        assert measured is not None
        off = np.log(measured.response / truth_at(measured.frequency))
        # To first order, so where the coherence is not small: about the resonance.
        near = (measured.frequency > 20.0) & (measured.frequency < 36.0)
        inside.append((np.abs([off.real, off.imag]) < measured.half_width)[:, near])
    assert 0.93 < np.mean(inside) < 0.98


def test_where_a_segment_begins_does_not_leak_into_an_integrating_response():
    draw = np.random.default_rng(4)
    u = draw.normal(size=20_000)
    # Differences of samples on both sides see the integral at the middle of its step.
    y = PERIOD * (np.cumsum(u) - 0.5 * u)
    plain, better = (estimate_response([Record(PERIOD, u, y, u, how)], LENGTH, HIGHEST) for how in (False, True))
    assert plain is not None and better is not None
    z = np.exp(2j * np.pi * plain.frequency * PERIOD)
    off = [np.abs(part.response / (0.5 * PERIOD * (z + 1.0) / (z - 1.0)) - 1.0)[0] for part in (plain, better)]
    assert off[1] < 0.3 * off[0]


def test_frequencies_that_hold_leakage_alone_are_masked_and_short_records_have_no_response():
    time = PERIOD * np.arange(6000)
    sine = np.sin(2.0 * np.pi * 20.3 * time)
    found = estimate_response([Record(PERIOD, sine, sine, sine)], LENGTH, HIGHEST)
    assert found is not None
    near = np.abs(found.frequency - 20.3) < 1.5
    assert (
        not found.leaks[near].any()
        and found.leaks[(np.abs(found.frequency - 20.3) > 3.5) & (np.abs(found.frequency - 20.3) < 5.5)].all()
    )
    assert estimate_response([record(np.random.default_rng(5), 1000)], LENGTH, HIGHEST) is None
    assert estimate_response([], LENGTH, HIGHEST) is None


def numbers():
    """Numbers of a vehicle whose lags up and down are alike."""
    space = space_of(PRIOR, ["1"])
    found = space.numbers(space.center)
    return found._replace(
        lag_up=0.04, lag_down=0.04, dead_time=0.004, climb_drag=0.02, inertia=Vec3(1.1e-5, 1.2e-5, 2e-5)
    )


def test_the_responses_of_the_model_are_those_of_python_control():
    vehicle, given, at = AIRFRAME.vehicle, numbers(), 0.55
    frequency = np.geomspace(0.5, 60.0, 25)
    ours = model_response(given, vehicle, at, frequency, PERIOD)
    slope = given.curve[1] + 2.0 * at * given.curve[2]
    lag, s = control.tf([1.0], [given.lag_up, 1.0]), control.tf("s")
    # Butterworth's second-order low-pass.
    gyro = control.tf(*signal.butter(2, np.sqrt(2.0) / given.gyro_delay, analog=True))
    y, x = (float(np.abs(np.array(places)).sum()) for places in (vehicle.rotor_y, vehicle.rotor_x))
    reaction = vehicle.rotor_inertia * np.sqrt(given.thrust[-1] / vehicle.thrust_coefficient)
    axes = [
        slope * y / (given.inertia.x * s + given.rate_damping),
        slope * x / (given.inertia.y * s + given.rate_damping),
        4.0 * (given.torque_ratio * slope + reaction * s) / (given.inertia.z * s),
        4.0 * slope / given.mass * s / (s + given.climb_drag / given.mass),
    ]
    z = np.exp(2j * np.pi * frequency * PERIOD)
    for k, axis in enumerate(axes):
        held = control.sample_system(lag * axis * (gyro if k < 3 else 1.0), PERIOD, method="zoh")
        theirs = held(z) * z ** (-given.dead_time / PERIOD)
        # Ours leaves out what sampling folds down, most where the response falls slowly.
        assert np.abs(ours[:, k] / theirs - 1.0).max() < (0.01 if k < 2 else 0.05), k


def test_the_responses_of_the_model_are_those_of_its_own_simulation():
    given, draw = numbers(), np.random.default_rng(6)
    noise = signal.lfilter([0.2], [1.0, -0.8], draw.normal(size=(20_000, 4)), axis=0)
    part = LogSegment(0, np.zeros(20_000), 0.0, PERIOD, 2, np.zeros((20_000, 3)), np.zeros(20_000), 0.55 + 0.02 * noise)
    turned, lift = turning(part, lagging(part, [actuator(given)])[0], given, AIRFRAME.vehicle)
    rates = np.concatenate([np.zeros((1, 3)), np.cumsum(0.5 * PERIOD * (turned[1:] + turned[:-1]), axis=0)])
    rates = low_passed(rates, PERIOD, given.gyro_delay)
    commands = axis_commands(AIRFRAME.vehicle, part.command)
    for k, output in enumerate([*rates.T, lift]):
        u = commands[:, k]
        found = estimate_response([Record(PERIOD, u, output, u, k < 3)], 2.0, 50.0)
        assert found is not None
        model = model_response(given, AIRFRAME.vehicle, 0.55, found.frequency, PERIOD)[:, k]
        off = np.log(found.response / model)
        # Damping by the rates themselves is not in this simulation.
        # Differences of the rotors' speed and straight lines between samples lose 10 % of yaw at 50 Hz.
        assert np.abs(off[found.frequency > 8.0]).max() < (0.11 if k == 2 else 0.08), k


def test_the_deviation_of_the_model_is_that_of_draws_of_its_numbers():
    space, draw = space_of(PRIOR, ["1"]), np.random.default_rng(7)
    deviations = 0.02 * space.prior_std
    frequency = np.array([1.0, 5.0, 20.0])
    setting = (AIRFRAME.vehicle, 0.55, frequency, PERIOD)
    ours = response_deviation(space, space.center, np.diag(deviations**2), setting)
    center = model_response(space.numbers(space.center), *setting)
    points = space.center + deviations * draw.normal(size=(2000, len(deviations)))
    drawn: Any = np.log(np.array([model_response(space.numbers(point), *setting) for point in points]) / center)
    assert ours[0] == pytest.approx(drawn.real.std(axis=0), rel=0.08)
    assert ours[1] == pytest.approx(drawn.imag.std(axis=0), rel=0.08, abs=1e-5)


@pytest.fixture(scope="module")
def fitted(identified):
    return identified[0]


def compared(found, fit):
    noise = [*gyro_noise(found.logs), *white_noise([log.acceleration[:, 2:] for log in found.logs])]
    return compare_responses(fit, found.problem, noise, found.logs[0].rate)


def test_nothing_is_compared_beyond_what_the_log_holds(fitted):
    """The grid of the model is finer than a slow log, whose samples lie on straight lines there."""
    entries = compare_responses(fitted.fit, fitted.problem, [0.0] * 4, 100.0)
    assert all(entry.measured.frequency[-1] == pytest.approx(40.0, abs=1.0) for entry in entries)


def test_a_model_that_is_right_agrees_and_a_wrong_one_is_named_with_its_band(fitted):
    entries = compared(fitted, fitted.fit)
    assert [entry.output for entry in entries] == ["roll", "pitch", "yaw", "lift"]
    assert not any("differs" in text for text in difference_words(entries))
    wrong = fitted.fit.estimate.copy()
    wrong[fitted.space.names.index("inertia.x")] += np.log(2.0)
    entries = compared(fitted, replace(fitted.fit, estimate=wrong))
    # The inertia about z is a share of those about x and y.
    first, second, rest = difference_words(entries)
    assert first.startswith("The frequency response of roll differs from the model from ") and "feedback" in first
    assert second.startswith("The frequency response of yaw differs from the model from ")
    assert entries[0].band is not None
    # Half of the inertia is twice of the response.
    off = entries[0].difference[entries[0].band].real
    assert np.median(off) == pytest.approx(np.log(2.0), abs=0.1)
    assert rest.startswith("The model agrees with the frequency response of pitch and lift")


def test_setpoints_are_the_instrument_where_they_move(fitted):
    samples = tuple(replace(part, setpoint=part.gyro * [1.0, 1.0, 0.0]) for part in fitted.problem.samples)
    noise = [0.0] * 4
    entries = compare_responses(fitted.fit, replace(fitted.problem, samples=samples), noise, RATE)
    assert [entry.has_instrument for entry in entries] == [True, True, False, False]
    assert [row.instrument for row in response_rows(entries)] == ["setpoint", "setpoint", "", ""]


def test_the_document_holds_both_responses(fitted):
    document = identification_document(fitted, [], None)
    row, entry = document.responses[0], compared(fitted, fitted.fit)[0]
    assert row.magnitude == pytest.approx(20.0 * np.log10(np.abs(entry.measured.response)), abs=1e-3)
    assert row.model_magnitude == pytest.approx(20.0 * np.log10(np.abs(entry.modeled)), abs=1e-3)
    turns = (np.array(row.phase) - np.degrees(np.angle(entry.measured.response))) / 360.0
    assert turns == pytest.approx(np.round(turns), abs=1e-4)
    assert "frequency response" in document.verdict and any(row.compared)


def distances_from_chirp_core(file):
    """Largest distances to betaflight-chirp-core's responses of rates to setpoints where its coherence exceeds 0.8.

    In [dB] and [degrees], with the number of frequencies, for each axis. Without columns of throttle and debug it takes all of
    a recording, and a window of 1024 samples as here.
    """
    theirs = pytest.importorskip("betaflight_chirp_core")
    log, (frame, rate, config) = read_log(file), theirs.decode(file.read_bytes())
    assert log.setpoint is not None and log.rate == pytest.approx(rate, rel=1e-3)
    left_out = [name for name in frame.columns if name == "rcCommand[3]" or name.startswith("debug")]
    how = {"input_col": "setpoint", "fmin": 1.0, "fmax": 60.0, "nperseg": 1024}
    analysed = theirs.analyse_log(frame.drop(columns=left_out), rate, config, **how)["axes"]
    distances = {}
    for k, axis in enumerate(("roll", "pitch", "yaw")):
        made = Record(log.period, log.setpoint[:, k], log.gyro[:, k], log.setpoint[:, k])
        ours = estimate_response([made], 1024 * log.period, 100.0)
        assert ours is not None
        names = ("freq", "gain_db", "phase_deg", "coherence")
        frequency, magnitude, phase, coherence = (np.array(analysed[axis][name]) for name in names)
        at = np.interp(frequency, ours.frequency, np.arange(float(len(ours.frequency))))
        # Their table is rounded and thinner.
        near = ours.response[np.round(at).astype(int)]
        shown = (coherence > 0.8) & (frequency >= ours.frequency[0]) & (frequency <= 60.0)
        off: Any = np.log(near / (10.0 ** (magnitude / 20.0) * np.exp(1j * np.radians(phase))))[shown]
        distances[axis] = (
            np.abs(DECIBELS * off.real).max(),
            np.degrees(np.abs(off.imag).max()),
            np.count_nonzero(shown),
        )
    return distances


def test_responses_are_those_of_betaflight_chirp_core_on_the_same_file(tmp_path):
    made, draw = truth(20_000, 1000.0), np.random.default_rng(8)
    b, a = signal.cont2discrete(([(40.0 * np.pi) ** 2], [1.0, 80.0, (40.0 * np.pi) ** 2]), 0.001)[:2]
    time = made.time - made.time[0]
    sweep = signal.chirp(time, 1.0, time[-1], 60.0, method="logarithmic", phi=-90.0)[:, None] * [1.0, 0.8, 0.6]
    rates = signal.lfilter(np.ravel(b), a, sweep, axis=0) + 0.02 * draw.normal(size=sweep.shape)
    file = tmp_path / "chirp.bbl"
    file.write_bytes(blackbox(made._replace(gyro=rates), sweep))
    for magnitude, phase, count in distances_from_chirp_core(file).values():
        assert magnitude < 0.5 and phase < 5.0 and count > 30
