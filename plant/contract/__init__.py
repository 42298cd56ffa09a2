"""The contracts of laws, metrics and references, bundled or of the user's own, as code that tests and `tuner check` share."""
