"""Published problems of multi-objective and constrained optimization, to compare searches at 50 to 300 evaluations.

Run `python -m benchmarks.search.published`.
"""
