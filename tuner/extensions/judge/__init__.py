"""A controller against hard limits: flown, judged, and said in a word that a build server understands."""
