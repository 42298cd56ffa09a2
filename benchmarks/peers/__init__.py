"""Other ways to fly the same course, each in its own environment, measured in turns. Run `python -m benchmarks.peers`."""
