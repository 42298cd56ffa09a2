"""One command from flight logs and a parameter file to first flights."""
