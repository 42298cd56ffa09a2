"""Tails: small probabilities of events of a flight."""
