"""A vehicle's file of command lines: profile 0 classic, profile 1 with the law."""

import pytest

HEAD = "# Betaflight / STM32F411 (S411) 2026.12.0-alpha Sep 19 2026 / 10:12:13 ({revision}) MSP API: 1.48\n"
SETTINGS = {
    "adrc_wc_yaw": "97",
    "adrc_wo_yaw": "110",
    "adrc_b0_yaw": "3586",
    "adrc_hover_throttle": "29",
    "adrc_b0_law": "FIXED",
    "gyro_lpf1_dyn_min_hz": "0",
    "gyro_lpf1_static_hz": "0",
    "gyro_lpf2_static_hz": "0",
}


@pytest.fixture
def vehicle(tmp_path):
    """Write a file of command lines: profile 0 classic, profile 1 with the law."""

    def write(revision="e6511d6ac", **changes):
        lines = [f"set {name} = {value}" for name, value in (SETTINGS | changes).items()]
        text = "\n".join(
            ["profile 0", "set p_roll = 50", "profile 1", "set pid_type = ADRC", *lines, "profile 1", "save", ""]
        )
        path = tmp_path / "diff.txt"
        path.write_text(HEAD.format(revision=revision) + text)
        return path

    return write
