"""The public Python interface, behind `import tuner`; the command line is a thin layer over it."""
