"""What a controller costs on a microcontroller: instructions, bytes of code and constants, state and stack, counted."""
