"""Cost of a controller on a microcontroller, counted: instructions, bytes of code and constants, state and stack."""
