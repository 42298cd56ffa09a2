"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="textbook_laws",
    about="Laws that textbooks print: PID in its forms, first-order ADRC, Smith predictor, feed-forward, lead-lag.",
)
