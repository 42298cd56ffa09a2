"""Parameter files of autopilots, read back as controllers of ours."""
