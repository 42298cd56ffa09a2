"""Trajectories of errors and their rates."""
