"""A plant with 95 % intervals out of measured inputs and outputs."""
