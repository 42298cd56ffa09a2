"""The RPM filter of Betaflight: a vehicle's settings fly as our notches and come back as they were."""

from dataclasses import replace

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.nominal import ControlOptions
from tuner.exchange.registry import settings_of
from tuner.exchange.run import bundle_of
from tuner.exchange.target import Request
from tuner.extensions.betaflight.export import TARGET
from tuner.extensions.betaflight.import_ import IMPORTER
from tuner.extensions.betaflight.rpm_filter import RPM_TABLE

HEAD = "# Betaflight / STM32F405 (S405) 2025.12.1 Dec 20 2025 / 10:00:00 (0123456) MSP API: 1.47\n"
ON = {"dshot_bidir": "ON"}
RPM = dict(zip(RPM_TABLE, ("2", "750", "120", "60"), strict=True))


def imported(tmp_path, texts, *more):
    """The controller that a vehicle's own loops are read as, with its notes."""
    file = tmp_path / "vehicle.txt"
    file.write_text(HEAD + "".join(f"set {name} = {text}\n" for name, text in texts.items()))
    return IMPORTER.read(file, load("racer5"), settings_of(IMPORTER, ["loops=own", *more]))


def exported(controller):
    """The settings that an export writes, by name, and the whole bundle."""
    bundle = bundle_of(TARGET, Request(controller, "0" * 64, settings_of(TARGET, []), None))
    (text,) = [content.decode() for content in bundle.files.values()]
    lines = [line.removeprefix("set ").split(" = ") for line in text.splitlines() if line.startswith("set ")]
    return dict(lines), bundle


def test_a_vehicles_rpm_filter_flies_and_comes_back(tmp_path):
    found = imported(tmp_path, {**ON, **RPM})
    options = found.controller.options
    assert (options.rpm_notches, options.rpm_notch_q, options.rpm_notch_min) == (2, 7.5, 120.0)
    assert not any("notches that follow" in note for note in found.notes)
    settings, bundle = exported(found.controller)
    assert {name: settings[name] for name in RPM} == RPM
    assert bundle.held.options == options
    said = " ".join(bundle.differences)
    assert "only with dshot_bidir = ON" in said and "are not written" not in said


@pytest.mark.parametrize("telemetry", [{}, {"dshot_bidir": "OFF"}])
def test_a_filter_without_telemetry_is_named_and_not_flown(telemetry, tmp_path):
    found = imported(tmp_path, {**telemetry, **RPM})
    assert found.controller.options.rpm_notches == 0
    assert any("acts where dshot_bidir = ON" in note for note in found.notes)
    settings, bundle = exported(found.controller)
    assert not set(RPM) & set(settings)
    assert "RPM and dynamic notches stay as they are" in " ".join(bundle.differences)


def test_defaults_of_the_firmware_hold_where_the_file_is_silent(tmp_path):
    options = imported(tmp_path, ON).controller.options
    assert (options.rpm_notches, options.rpm_notch_q, options.rpm_notch_min) == (3, 5.0, 100.0)
    assert imported(tmp_path, {**ON, "rpm_filter_harmonics": "0"}).controller.options.rpm_notches == 0


def test_what_our_notches_have_not_is_named(tmp_path):
    texts = {
        **ON,
        **RPM,
        "rpm_filter_fade_range_hz": "50",
        "rpm_filter_weights": "100,0,80",
        "rpm_filter_lpf_hz": "150",
    }
    (note,) = [note for note in imported(tmp_path, texts).notes if "notches that follow" in note]
    assert "rpm_filter_weights = 100,0,80" in note and "rpm_filter_fade_range_hz = 50 in place of 60" in note
    assert "rpm_filter_lpf_hz" not in note


def test_rounding_to_whole_settings_is_what_is_verified(tmp_path):
    found = imported(tmp_path, {**ON, **RPM}).controller
    between = replace(found, options=replace(found.options, rpm_notch_q=4.123456, rpm_notch_min=99.6))
    settings, bundle = exported(between)
    assert (settings["rpm_filter_q"], settings["rpm_filter_min_hz"]) == ("412", "100")
    np.testing.assert_allclose([bundle.held.options.rpm_notch_q, bundle.held.options.rpm_notch_min], [4.12, 100.0])


def test_notches_beyond_the_firmwares_range_are_refused(tmp_path):
    found = imported(tmp_path, {**ON, **RPM}).controller
    wide = replace(found, options=replace(found.options, rpm_notch_q=2.0))
    with pytest.raises(
        InputError, match=r"rpm_filter_q: works out at 200 .*allowed 250 to 3000 .*: change controller.rpm_notch_q"
    ):
        exported(wide)


def test_a_controller_without_notches_leaves_the_vehicles_filter(tmp_path):
    plain = imported(tmp_path, {"p_roll": "45"}).controller
    assert plain.options.rpm_notches == ControlOptions().rpm_notches == 0
    assert not set(RPM) & set(exported(plain)[0])
