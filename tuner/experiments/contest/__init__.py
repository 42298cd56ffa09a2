"""Contests: several controllers under one base study, tuned or as given, compared flight by flight in the same air."""
