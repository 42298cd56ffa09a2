"""The linear loop against margins that its pilots printed, closed forms, and the law itself."""

from math import degrees, log10

import numpy as np
import pytest

from tuner.extensions.betaflight_adrc import equations
from tuner.extensions.betaflight_adrc.linear_loop import (
    AxisPlant,
    Sampling,
    controller_response,
    loop_response,
    margins,
    plant_response,
)
from tuner.extensions.betaflight_adrc.settings import default_tune

POINTS = np.array([3.0, 10.0, 30.0, 60.0])


def tune_of(wc, wo, b0, cutoff=150.0, sigma=3.0):
    names = ("roll", "pitch", "yaw")
    numbers = {
        f"adrc_{name}_{axis}": float(value)
        for axis in names
        for name, value in zip(("wc", "wo", "b0"), (wc, wo, b0), strict=True)
    }
    return default_tune().with_numbers({**numbers, "adrc_gyro_lpf_hz": cutoff, "adrc_sigma_decay": sigma})


@pytest.mark.parametrize(
    ("wc", "wo", "lag", "ratio", "phase", "gain"),
    [
        (60, 100, 0.010, 1.0, 74.9, 12.1),
        (60, 100, 0.020, 1.0, 60.1, 9.8),
        (99, 110, 0.020, 1.0, 47.8, 8.2),
        (103, 140, 0.030, 1.0, 33.0, 6.7),
        (140, 150, 0.020, 1.0, 34.9, 6.5),
        (60, 100, 0.020, 1.5, 42.8, 6.3),
        (60, 100, 0.020, 3.0, 2.2, 0.3),
    ],
)
def test_margins_printed_in_the_pull_request(wc, wo, lag, ratio, phase, gain):
    """The documentation of pull request 15400: 8 kHz, low-passes of 250, 500 and 150 Hz; ratio: b over b0."""
    found = margins(tune_of(wc, wo, 2000), "roll", AxisPlant(2000.0 * ratio * lag, lag, 0.0), Sampling())
    assert degrees(found.phase) == pytest.approx(phase, abs=0.2)
    assert 20.0 * log10(found.gain) == pytest.approx(gain, abs=0.1)


@pytest.mark.parametrize(
    ("axis", "b0", "plant", "phase", "gain"),
    [
        ("roll", 6560, (135.2, 0.0211, 0.0022, 0.0), 56.0, 9.0),
        ("pitch", 3936, (92.9, 0.0214, 0.0023, 0.0), 51.0, 7.9),
        ("yaw", 2624, (13.2, 0.0256, 0.0026, 0.130), 13.0, 1.3),
    ],
)
def test_margins_printed_of_a_craft_with_a_chirp(axis, b0, plant, phase, gain):
    """The 2.5 in craft TH3+ at 4 kHz, plants and margins as its pilot printed them."""
    gain_, lag, delay, zero = plant
    sampling = Sampling(250e-6, 250e-6, (1000.0,))
    found = margins(tune_of(81, 90, b0, 0.0), axis, AxisPlant.identified(gain_, lag, delay, 250e-6, zero), sampling)
    assert degrees(found.phase) == pytest.approx(phase, abs=2.0)
    assert 20.0 * log10(found.gain) == pytest.approx(gain, abs=0.4)
    assert axis != "yaw" or found.ring == pytest.approx(65.0, abs=1.0)


def test_the_controller_tends_to_its_continuous_form():
    wc, wo, b, period = 70.0, 110.0, 3000.0, 1e-6
    s = 2j * np.pi * POINTS
    constants = tune_of(wc, wo, b, 0.0, 0.0).axis("roll", period)
    above = s**2 * wo * (3 * wc**2 + 6 * wc * wo + wo**2) + s * wc * wo**2 * (3 * wc + 2 * wo) + wc**2 * wo**3
    below = b * s * (s**2 + (2 * wc + 3 * wo) * s + wc**2 + 6 * wc * wo + 3 * wo**2)
    flying = controller_response(constants, 1.0, True, np.exp(s * period), period)
    np.testing.assert_allclose(flying, above / below, rtol=2e-3)
    wc = constants.ground_wc
    ground = (3 * wo * (wc**2 + 2 * wc * wo) * s + 3 * wc**2 * wo**2) / (b * (s**2 + 3 * wo * s + 3 * wo**2))
    np.testing.assert_allclose(
        controller_response(constants, 1.0, False, np.exp(s * period), period), ground, rtol=2e-3
    )


@pytest.mark.parametrize(("lag", "damping"), [(0.0, 2.0), (22.0, 2.0), (0.0, 1.0)])
def test_the_controller_is_the_law_as_it_steps(lag, damping):
    """The transform of the law's answer to a pulse of rate, scheduled at twice b0, with motor pole or damping ratio."""
    tune, period = tune_of(70, 110, 3000, 0.0, 50.0), 1e-3
    constants = tune.axis("roll", period)._replace(inverse_tau=1e3 / lag if lag else 0.0, damping=damping)
    gate = equations.Gate(1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0)
    memory, answer = equations.seeded(0.0), []
    for k in range(6000):
        terms, memory = equations.step_axis(memory, constants, gate, float(k == 0), 0.0, 0.0, period)
        memory = memory._replace(output=sum(terms))
        answer.append(memory.output)
    z = np.exp(2j * np.pi * POINTS * period)
    transform = np.array([np.sum(np.array(answer) * point ** -np.arange(len(answer))) for point in z])
    np.testing.assert_allclose(controller_response(constants, 2.0, True, z, period), -transform, rtol=1e-6)


@pytest.mark.parametrize("delay", [0.0, 0.3e-3, 1e-3, 2.6e-3])
def test_the_held_plant_is_that_of_a_fine_simulation(delay):
    """The first 400 samples of the answer to a pulse held over one period, by integrals of the step response."""
    plant, period = AxisPlant(13.2, 0.0256, delay, 0.130), 1e-3
    z = np.asarray(1.05 * np.exp(2j * np.pi * POINTS * period), dtype=np.complex128)

    def step(time):
        late = np.maximum(time - delay, 0.0)
        return plant.gain * (late + (plant.zero - plant.lag) * (1.0 - np.exp(-late / plant.lag)))

    k = np.arange(400)
    pulse = step(k * period) - step((k - 1) * period)
    np.testing.assert_allclose(plant_response(plant, z, period), (pulse * z[:, None] ** -k).sum(axis=1), rtol=1e-6)


def test_a_wrong_b0_moves_no_frequency():
    plant, sampling = AxisPlant(40.0, 0.02, 0.002), Sampling()
    rings = [margins(tune_of(60, 100, b0), "roll", plant, sampling).ring for b0 in (1000, 2000, 4000)]
    assert max(rings) - min(rings) < 1e-4
    response = [loop_response(tune_of(60, 100, b0), "roll", plant, sampling, POINTS) for b0 in (1000, 2000)]
    np.testing.assert_allclose(response[0], 2.0 * response[1], rtol=1e-9)
