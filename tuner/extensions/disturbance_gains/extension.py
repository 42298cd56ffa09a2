"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.disturbance_gains"
EXTENSION = Extension(
    name="disturbance_gains",
    about="Limits on the largest gain, over frequency, from a disturbance to any output of a plant.",
    requirements={"disturbance_gain": f"{HOME}.requirement:KIND"},
)
