"""Gains that leave the building: exporters that carry a controller exactly or refuse with the reason."""
