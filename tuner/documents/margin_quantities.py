"""Margin quantities of margins.parquet, and the units that a reader sees."""

from math import pi

# Name in margins.parquet, label, unit shown, factor to it, whether it is shown in dB, meaning.
QUANTITIES = (
    ("gain_up", "gain margin up", "dB", 1.0, True, "how far the loop gain may rise before the loop is unstable"),
    ("gain_down", "gain margin down", "dB", 1.0, True, "how far the loop gain may fall before the loop is unstable"),
    ("phase_margin", "phase margin", "°", 180.0 / pi, False, "least phase lag, or lead, that makes the loop unstable"),
    ("delay_margin", "delay margin", "ms", 1e3, False, "delay on top of what there is that makes the loop unstable"),
    ("ms", "Ms", "", 1.0, False, "peak of the sensitivity: how much the loop amplifies disturbances at worst"),
    ("mt", "Mt", "", 1.0, False, "peak of the complementary sensitivity: how much the reference is amplified at worst"),
    ("disk", "disk margin", "", 1.0, False, "size of the disk of simultaneous gain and phase changes that the loop bears"),
    ("bandwidth", "bandwidth", "rad/s", 1.0, False, "frequency up to which the reference is followed to within −3 dB"),
)  # fmt: skip
