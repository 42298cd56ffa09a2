"""Flights on many machines: `tuner run --dask`. Who schedules them is Dask; what they are is told in numbers and names."""
