"""Probabilities of rare events down to 1e-6, with intervals that cover: `estimate_tail` of a `LimitFunction`."""
