"""FMUs as plants (FMI 2 and 3, co-simulation): their archive, their description, their loop, one instance and its flights.

Reading an FMU runs nothing of it. Its machine code runs in worker processes (`objectives.fmu`).
"""
