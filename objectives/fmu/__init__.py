"""Flights of FMUs in worker processes: the system, its flyer, the brief of a worker and its side of the pipe."""
