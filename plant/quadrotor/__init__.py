"""Quadrotors: airframes, rigid body, rotors, sensors, the cascade of control loops, and the loops of autopilots."""
