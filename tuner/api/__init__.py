"""The public Python interface, behind `import tuner`; the command line is a thin layer over it."""

POSITION_LAW, AIRFRAME = "ladrc", "hummingbird"
"""Position law and airframe of default gains if no others are named."""
