"""FMUs as plants (FMI 2 and 3, co-simulation): archive, description, loop, instances and their flights.

Reading an FMU runs nothing of it. What it does with its machine code happens in worker processes.
"""
