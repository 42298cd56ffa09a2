"""Differences that matter: the one rule for two values on the same flights, and the table of its words.

With the 95 % interval of a paired difference, and `relevant`, the share of the reference's value below which a difference
is of no use to anybody, r = relevant * |reference|:

- better: the interval lies below 0, and the value below -r; worse: the mirror image.
- no practical difference: the interval lies within -r and r.
- not distinguishable: neither; more flights decide.

"Better" asks for two things (dual criterion: S. Roychoudhury, N. Scheuer, B. Neuenschwander, "Beyond p-values: a phase II
dual-criterion design with statistical significance and clinical relevance", Clinical Trials 15(5):452-461, 2018): that there
is a difference at all, which errs in at most 2.5 % of the cases without one, and that its best estimate matters. An interval
that lies beyond -r as a whole would ask for proof of relevance: a gain of 4 % known to 2.5 % would not be called better.
"No practical difference" is an equivalence test (D. J. Schuirmann, J. Pharmacokinetics and Biopharmaceutics 15(6):657-680,
1987: two one-sided tests, here at 2.5 % each): it is shown, and no consequence of few flights.

A reference of 0 has no share: there r is 0, and every significant difference counts. The reference is taken as it was measured.
"""

from collections.abc import Collection
from typing import NamedTuple

RELEVANT = 0.02
"""Default share of the reference's value from which a difference matters."""
BETTER, WORSE = "better", "worse"
NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE = "no practical difference", "not distinguishable"
MIXED = "mixed"


class DifferenceWord(NamedTuple):
    """Forms of a word on a difference.

    sign: sign next to the word, for readers who see no color. phrase: part of a sentence, {0} the other one, {1} the quantities.
    """

    sign: str
    phrase: str


WORDS = {
    BETTER: DifferenceWord("✓", "better than {0} in {1}"),
    WORSE: DifferenceWord("✗", "worse than {0} in {1}"),
    NO_PRACTICAL_DIFFERENCE: DifferenceWord("=", "without practical difference from {0} in {1}"),
    NOT_DISTINGUISHABLE: DifferenceWord("≈", "not distinguishable from {0} in {1}"),
}
"""Word on a difference -> its forms, in the order in which sentences list them."""


def classify_difference(reference: float, value: float, low: float, high: float, relevant: float = RELEVANT) -> str:
    """Return the word on a paired difference, of which less is better.

    Args:
        reference: Value of the one that is compared with.
        value: Difference, the other one less the reference.
        low: Lower end of its 95 % interval.
        high: Upper end of it.
        relevant: Share of the reference from which a difference matters.
    """
    bound = relevant * abs(reference)
    if -bound <= low and high <= bound:
        return NO_PRACTICAL_DIFFERENCE
    if high < 0.0 and value < -bound:
        return BETTER
    return WORSE if low > 0.0 and value > bound else NOT_DISTINGUISHABLE


def join_words(words: Collection[str]) -> str:
    """Return the joint word on several quantities."""
    if MIXED in words or (BETTER in words and WORSE in words):
        return MIXED
    decided = next((word for word in (WORSE, BETTER) if word in words), None)
    if decided is None and words and all(word == NO_PRACTICAL_DIFFERENCE for word in words):
        return NO_PRACTICAL_DIFFERENCE
    return decided or NOT_DISTINGUISHABLE
