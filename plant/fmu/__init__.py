"""FMUs as plants (FMI 2 and 3, co-simulation): their archive, their description, their loop, one instance and its flights.

Reading an FMU runs nothing of it. What it does with its machine code happens in worker processes (`objectives.fmu`).
"""
