"""The cost of a run and the certainty of its figures, estimated from a few candidates that are flown first."""
