"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="vehicle_fit",
    about="Parameters of a vehicle's model, fitted to logged flights by maximum likelihood.",
    requires=("logs",),
)
