"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.bench"
EXTENSION = Extension(
    name="bench",
    about="Speed of this machine: plant steps per second of each backend, flights, and time of margins.",
    command_module=f"{HOME}.command",
    commands=("bench",),
)
