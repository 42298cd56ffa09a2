"""What laws, metrics and references promise, bundled or of the user's own, as code that tests and `tuner check` share."""
