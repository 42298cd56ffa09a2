"""Rate loops of autopilots as attitude laws, each in the form and the units of its own firmware."""
