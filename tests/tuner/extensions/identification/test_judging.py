"""How far a fit may be believed: the band over windows that it did not use, spectra, whiteness, and the page that shows them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tuner.extensions.identification.known_flights import AIRFRAME, known_flights
from tuner.extensions.identification.building import identification_document, prediction_words
from tuner.extensions.identification.identify import identify_vehicle
from tuner.extensions.identification.judging import _noise_variance, density, validate_fit
from tuner.extensions.identification.page import identification_page
from tuner.extensions.vehicle_fit import fit
from tuner.extensions.vehicle_fit.prediction import SETTLING
from tuner.extensions.vehicle_fit.random_effects import QUANTILE


@pytest.mark.slow
def test_the_band_of_95_per_cent_holds_about_that_of_what_was_not_used():
    longer = [identify_vehicle([flight.log], AIRFRAME) for flight in known_flights(3, duration=12.0, seed=5)]
    covered = np.array([found.validation.covered for found in longer])
    # Noise whose memory is as long as a window leaves few independent samples.
    assert 0.85 < covered.mean() < 0.99


def test_a_wrong_lag_is_seen_in_the_band_and_in_what_is_left_over(identified):
    found = identified[0]
    point = found.early.estimate.copy()
    point[[found.space.names.index(name) for name in ("lag_up", "lag_down")]] += 0.8
    wrong = validate_fit(replace(found.early, estimate=point), found.problem)
    assert wrong.windows.explained[0] < found.windows.explained[0] - 0.05
    assert np.all(wrong.spectra[2][:3, 0] > found.validation.spectra[2][:3, 0])
    assert wrong.correlated[:2].max() > 0.25 > found.validation.correlated.max()


def test_a_posterior_without_numbers_has_a_narrower_band(identified):
    found = identified[0]
    sure = validate_fit(replace(found.early, covariance=0.0 * found.early.covariance), found.problem)
    assert np.all(sure.spread < found.validation.spread)


def test_how_the_delay_splits_does_not_widen_the_band(identified, monkeypatch):
    found = identified[0]
    whole = found.early.covariance - fit.split_covariance(found.space, found.early.estimate, found.early.free)
    monkeypatch.setattr(fit, "SPLIT", 0.0)
    assert validate_fit(replace(found.early, covariance=whole), found.problem).spread == pytest.approx(
        found.validation.spread
    )


def test_neither_fit_nor_validation_uses_the_begin_of_a_segment(identified):
    for found in identified:
        part, mask = found.problem.samples[0], found.problem.masks[0]
        assert not mask[part.time < part.begin + SETTLING].any()
        assert found.windows.time.min() >= part.begin + SETTLING


def test_the_density_of_white_noise_is_flat_and_that_of_a_sine_stands_at_its_frequency():
    period, draw = 0.004, np.random.default_rng(1)
    white = density(3.0 * draw.normal(size=(400, 125, 4)), period)
    assert np.mean(white**2) == pytest.approx(9.0 * 2.0 * period, rel=0.02)
    time = period * np.arange(125.0)
    sine = density(np.sin(2.0 * np.pi * 20.0 * time)[None, :, None].repeat(4, axis=2), period)
    assert np.fft.rfftfreq(125, period)[1:][np.argmax(sine[:, 0])] == pytest.approx(20.0)


def test_the_model_explains_slow_motion_and_not_the_noise_of_the_sensors(identified):
    for found in identified:
        assert np.all((found.validation.reach[:2] > 3.0) & (found.validation.reach[:2] < 60.0))


def test_the_verdict_names_a_band_that_is_too_narrow_and_what_is_not_white(identified):
    rows = identification_document(identified[0], [], None).prediction
    words = " ".join(prediction_words([rows[0].model_copy(update={"covered": 0.5, "correlated": 0.6}), *rows[1:]]))
    assert "holds only 50 % of roll" in words and "residual of roll is not white" in words
    assert "white behind the noise model" in prediction_words(rows)[-1]


def test_an_output_that_hardly_moves_on_the_windows_kept_is_not_called_poor(identified):
    found = identified[0]
    rows = identification_document(found, [], None).prediction
    assert all(row.moved is not None and 0.5 < row.moved < 2.0 for row in rows)
    still = rows[0].model_copy(update={"explained": 0.1, "moved": 0.05})
    words = " ".join(prediction_words([still, *rows[1:]]))
    assert "hold hardly any roll" in words and "predicted poorly" not in words
    document = identification_document(found, [], None).model_copy(update={"prediction": [still, *rows[1:]]})
    assert "hardly moved" in identification_page(found, document).text()
    moving = rows[0].model_copy(update={"explained": 0.1})
    assert "roll is predicted poorly" in " ".join(prediction_words([moving, *rows[1:]]))


def test_the_page_shows_what_is_told_and_what_is_not_and_no_markup_of_a_file_name(identified):
    found = identified[0]
    logs = (replace(found.logs[0], name="<script>alert(1)</script>"),)
    found = replace(found, logs=logs)
    document = identification_document(found, [], None)
    text = identification_page(found, document).text()
    assert document.verdict in text and "given: no log identifies it" in text and "<script>alert" not in text
    for row in document.prediction:
        assert all(f'id="{part}-{row.output}"' in text for part in ("prediction", "spectrum", "whiteness"))


def test_the_band_holds_its_share_of_residuals_whose_windows_differ_in_size():
    """Half of the windows in gusts of three times the size, on windows drawn anew; of a normal band they leave more."""
    draw = np.random.default_rng(8)

    def residuals(windows):
        return draw.choice([1.0, 3.0], size=(windows, 1, 4)) * draw.normal(size=(windows, 50, 4))

    used, fresh = residuals(4000), residuals(4000)
    share = np.mean(np.abs(fresh) <= QUANTILE * np.sqrt(_noise_variance(used)), axis=(0, 1))
    # Two standard deviations of 4,000 windows, used and fresh, are 0.3 points.
    assert share == pytest.approx([0.95] * 4, abs=0.004)
    assert np.all(np.mean(np.abs(fresh) <= QUANTILE * np.sqrt(np.mean(used**2, axis=0)), axis=(0, 1)) < share - 0.015)
