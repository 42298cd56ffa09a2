"""Results of contests in the Python API."""

from tuner.api.results import ComparedResults
from tuner.extensions.contests.documents import ContestDocument, ContestFolder


class ContestResults(ComparedResults[ContestDocument], ContestFolder):
    """Results of a contest: several controllers, each tuned, on the same flights."""
