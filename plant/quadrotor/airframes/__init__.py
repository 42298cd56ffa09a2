"""Airframes: every number of a vehicle with its unit and source, checked before anything flies."""

from plant.quadrotor.airframes.loader import Airframe, load, names

__all__ = ["Airframe", "load", "names"]
