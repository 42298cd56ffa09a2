"""Flights of FMUs in worker processes: the system, its flyer, the description of its loop and its side of the pipe."""
