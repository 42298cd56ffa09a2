"""Progress of long calls below the cell of a notebook."""
