"""Limits on gains from a disturbance to an output."""
