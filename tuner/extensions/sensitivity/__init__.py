"""Shares of gains and of turbulence in each result: Sobol indices and a decomposition of variance on real flights."""
