"""Contracts of laws, metrics and references, as code that tests and `tuner check` share."""
