"""A vehicle out of flight logs: numbers with a correlated uncertainty, and what the data do not tell."""
