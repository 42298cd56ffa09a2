"""Coverage and cost of intervals of small probabilities that are known exactly. Run `python -m benchmarks.tails`."""
