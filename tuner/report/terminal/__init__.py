"""The story of a results folder as data and as text for a terminal; the page of the same folder is in `tuner.report`."""
