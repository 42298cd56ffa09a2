"""Flights on many machines: `tuner run --dask`. Dask schedules them; they are sent as numbers and names."""
