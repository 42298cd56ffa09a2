"""A plant with 95 % intervals out of a table of measured inputs and outputs."""
