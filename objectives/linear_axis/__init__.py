"""One axis of a controller as linear loops."""
