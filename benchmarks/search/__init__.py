"""How good the searches of the tool and of others are, over flights and over processor time. Run `python -m benchmarks.search`."""
