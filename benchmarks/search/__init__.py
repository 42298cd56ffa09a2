"""The searches of the tool and of other packages beside each other, over flights and over processor time.

Run `python -m benchmarks.search`.
"""
