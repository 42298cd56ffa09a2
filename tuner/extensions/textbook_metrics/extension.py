"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="textbook_metrics",
    about="Metrics of a step as textbooks define them: ITAE without normalization, overshoot past the final value.",
)
