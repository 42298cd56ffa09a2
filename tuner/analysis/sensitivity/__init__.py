"""Which gains decide, and how much is turbulence: Sobol indices and a decomposition of variance on real flights."""
