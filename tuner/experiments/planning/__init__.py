"""Cost and precision of a run, estimated from a pilot: a few candidates that are flown first."""
