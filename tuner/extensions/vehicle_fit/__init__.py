"""Parameters of a vehicle's model, fitted to logged flights by maximum likelihood."""
