"""FMUs as plants (FMI 2 and 3, co-simulation): archive, description, loop, instances and their flights.

Reading an FMU runs nothing of it. Its machine code runs in worker processes.
"""
