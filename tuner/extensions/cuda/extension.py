"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.cuda"
EXTENSION = Extension(
    name="cuda",
    about="Flights on an NVIDIA card, in double or in single precision.",
    backends={"cuda": f"{HOME}.backends:DOUBLE", "cuda-float32": f"{HOME}.backends:SINGLE"},
)
