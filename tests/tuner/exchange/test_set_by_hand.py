"""What an export says of options that no exporter writes: notches that follow the rotors, compensation of a battery."""

from plant.quadrotor.nominal import ControlOptions
from tuner.exchange.run import battery_texts, notch_texts


def test_an_export_says_what_to_set_for_them():
    """In the numbers of Betaflight's settings; nothing where there are none."""
    (said,) = notch_texts(ControlOptions(rpm_notches=3))
    assert (
        "rpm_filter_harmonics = 3, rpm_filter_q = 500, rpm_filter_min_hz = 100, rpm_filter_fade_range_hz = 50" in said
    )
    assert notch_texts(ControlOptions()) == ()


def test_an_export_says_what_to_set_for_the_battery():
    """By the names of targets that have it; nothing where it is off."""
    (said,) = battery_texts(ControlOptions(battery_compensation=0.5))
    assert "50% of it" in said and "MC_BAT_SCALE_EN in PX4" in said
    assert battery_texts(ControlOptions()) == ()
