"""Settings of Betaflight 2025.12 that an export writes: units, ranges, defaults; and those of pull request 15400.

betaflight/betaflight, release 2025.12: src/main/cli/settings.c, src/main/flight/pid.h and pid.c (pgResetFn_pidProfiles); for ADRC
the head 6317fe2 of pull request 15400. The firmware enforces these ranges.
"""

from tuner.export.parameter_table import Entry

OFF = "nothing: it is switched off"


def _axis(axis: str, p: float, i: float, d: float, d_max: float, f: float) -> list[Entry]:
    """Return one rate loop with its defaults."""
    return [
        Entry(f"p_{axis}", "1", 0.0, 250.0, p, f"{axis}.kd"),
        Entry(f"i_{axis}", "1", 0.0, 250.0, i, f"{axis}.ki"),
        Entry(f"d_{axis}", "1", 0.0, 250.0, d, OFF),
        Entry(f"d_max_{axis}", "1", 0.0, 250.0, d_max, OFF),
        Entry(f"f_{axis}", "1", 0.0, 1000.0, f, OFF),
    ]


TABLE = {
    entry.name: entry
    for entry in (
        *_axis("roll", 45.0, 80.0, 30.0, 40.0, 120.0),
        *_axis("pitch", 47.0, 84.0, 34.0, 46.0, 125.0),
        *_axis("yaw", 45.0, 80.0, 0.0, 0.0, 120.0),
        Entry("angle_p_gain", "0.1/s", 0.0, 200.0, 50.0, "roll.kp, roll.ki or roll.kd"),
        Entry("angle_feedforward", "1", 0.0, 200.0, 50.0, OFF),
        Entry("angle_limit", "deg", 10.0, 85.0, 60.0, "controller.tilt_limit"),
        Entry("anti_gravity_gain", "1", 0.0, 250.0, 80.0, OFF),
        Entry("tpa_rate", "%", 0.0, 100.0, 65.0, OFF),
        Entry("yaw_lowpass_hz", "Hz", 0.0, 500.0, 100.0, OFF),
        Entry("iterm_limit", "1", 0.0, 500.0, 400.0, "nothing: it is the largest"),
        Entry("thrust_linear", "%", 0.0, 150.0, 0.0, OFF),
    )
}
# Switches: setting -> what the export sets, the default.
SWITCHES = {
    "simplified_pids_mode": ("OFF", "RPY"),
    "iterm_relax": ("OFF", "RP"),
    "use_integrated_yaw": ("OFF", "OFF"),
}


def _adrc(axis: str, wo: float) -> list[Entry]:
    return [
        Entry(f"adrc_wc_{axis}", "rad/s", 5.0, 300.0, 60.0, f"{axis}.omega_c"),
        Entry(f"adrc_wo_{axis}", "rad/s", 10.0, 600.0, wo, f"{axis}.omega_o"),
        Entry(f"adrc_b0_{axis}", "deg/s3", 100.0, 65535.0, 2000.0, "the airframe or --set thrust_curve"),
    ]


ADRC_TABLE = {
    entry.name: entry
    for entry in (
        *_adrc("roll", 100.0),
        *_adrc("pitch", 100.0),
        *_adrc("yaw", 80.0),
        Entry("adrc_hover_throttle", "%", 5.0, 100.0, 35.0, "the airframe or --set thrust_curve"),
        Entry("adrc_sigma_decay", "0.1/s", 0.0, 100.0, 3.0, OFF),
    )
}
ADRC_SWITCHES = {"pid_type": ("ADRC", "CLASSIC")}
