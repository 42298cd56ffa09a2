"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="logs",
    about="Readers of flight logs: ULog, DataFlash, Betaflight, Crazyflie, CSV.",
)
