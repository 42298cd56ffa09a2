"""Plants of the user's own: one file with records and two functions, closed by the same laws and flown by the same backends."""
