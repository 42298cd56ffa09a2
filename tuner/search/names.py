"""Names of the searches, kept apart from the searches themselves because importing those is slow."""

ALGORITHMS = ("nsga2",)
STARTS = ("default", "design")
