"""Margins for people: what `tuner margins` prints, writes as JSON and draws. The numbers come from `objectives.margins`."""
