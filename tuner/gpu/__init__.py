"""Flights on a graphics card: `tuner run --backend cuda`."""
