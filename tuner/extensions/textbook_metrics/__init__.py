"""Metrics of a step as textbooks define them."""
