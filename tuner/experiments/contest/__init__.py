"""Contests: several controllers under one base study, tuned or as given, compared flight by flight in the same air."""

from tuner.study.contest import Claim, Contender, Contest, Published, Quantity
from tuner.study.contest_reading import contest_from_table, is_contest, load_contest

__all__ = [
    "Claim", "Contender", "Contest", "Published", "Quantity", "contest_from_table", "is_contest", "load_contest",
]  # fmt: skip
