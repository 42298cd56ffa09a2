"""The rule for differences: its table, its symmetries, and how often it errs where nothing differs."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, multinomial

from objectives.risk import Risk, classify_difference, join_words, share_difference
from objectives.risk.differences import BETTER, MIXED, NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE, WORDS, WORSE
from plant.seeds import generator
from tests.objectives.risk.resampling import paired_difference

CASES = {
    "beyond 2 %, the interval below 0": ((1.0, -0.03, -0.05, -0.001), BETTER),
    "the mirror image": ((1.0, 0.03, 0.001, 0.05), WORSE),
    "sure, and of no use": ((1.0, -0.001, -0.0012, -0.0008), NO_PRACTICAL_DIFFERENCE),
    "nothing at all": ((1.0, 0.0, 0.0, 0.0), NO_PRACTICAL_DIFFERENCE),
    "the same gains within rounding": ((1.0, 1e-12, 1e-12, 1e-12), NO_PRACTICAL_DIFFERENCE),
    "sure, and perhaps of use": ((1.0, -0.019, -0.025, -0.013), NOT_DISTINGUISHABLE),
    "large, and not sure": ((1.0, -0.2, -0.41, 0.01), NOT_DISTINGUISHABLE),
    "an end at 0 leaves out nothing": ((1.0, -0.2, -0.4, 0.0), NOT_DISTINGUISHABLE),
    "small, and not sure": ((1.0, -0.005, -0.03, 0.02), NOT_DISTINGUISHABLE),
    "in units a thousand times as small": ((1000.0, -30.0, -50.0, -1.0), BETTER),
    "a reference below 0": ((-1.0, -0.03, -0.05, -0.001), BETTER),
    "a reference of 0, and no more seen": ((0.0, 0.0, -0.0143, 0.0143), NOT_DISTINGUISHABLE),
    "a reference of 0, and more": ((0.0, 0.02, 0.004, 0.05), WORSE),
    "nothing beside nothing": ((0.0, 0.0, 0.0, 0.0), NO_PRACTICAL_DIFFERENCE),
}


@pytest.mark.parametrize(("numbers", "word"), CASES.values(), ids=CASES)
def test_a_word_on_a_difference(numbers, word):
    assert classify_difference(*numbers) == word


@pytest.mark.parametrize(
    ("relevant", "word"), [(0.0, BETTER), (0.02, BETTER), (0.04, NOT_DISTINGUISHABLE), (0.06, NO_PRACTICAL_DIFFERENCE)]
)
def test_a_study_says_from_which_share_on_a_difference_matters(relevant, word):
    assert classify_difference(1.0, -0.03, -0.05, -0.01, relevant) == word


NUMBERS = st.floats(-1.0, 1.0, allow_nan=False)


@given(st.floats(0.01, 100.0), NUMBERS, st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 0.5))
def test_a_mirrored_difference_has_the_mirrored_word_and_units_do_not_matter(reference, value, below, above, relevant):
    low, high = value - below, value + above
    word = classify_difference(reference, value, low, high, relevant)
    mirrored = {BETTER: WORSE, WORSE: BETTER}
    assert classify_difference(reference, -value, -high, -low, relevant) == mirrored.get(word, word)
    assert classify_difference(4.0 * reference, 4.0 * value, 4.0 * low, 4.0 * high, relevant) == word
    # By what each word promises.
    assert word != BETTER or (high < 0.0 and -value > relevant * reference)
    assert word != NO_PRACTICAL_DIFFERENCE or max(abs(low), abs(high)) <= relevant * reference
    assert word in WORDS


@pytest.mark.parametrize(
    ("words", "joint"),
    [
        ([BETTER, NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE], BETTER),
        ([NO_PRACTICAL_DIFFERENCE, WORSE], WORSE),
        ([BETTER, WORSE], MIXED),
        ([MIXED], MIXED),
        ([NO_PRACTICAL_DIFFERENCE] * 2, NO_PRACTICAL_DIFFERENCE),
        ([NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE], NOT_DISTINGUISHABLE),
        ([], NOT_DISTINGUISHABLE),
    ],
)
def test_words_on_several_quantities_are_joined(words, joint):
    assert join_words(words) == joint


REPEATS, FLIGHTS = 400, 256


def words_without_difference(risk, spread, losses, flights, repeats):
    """Return the counts of words on pairs that differ by chance alone; losses: share of flights that cost 40 times as much."""
    words = Counter()
    for k in range(repeats):
        rng = generator(1, "test/no-difference", k)
        pair = np.exp(0.5 * rng.standard_normal(flights) + spread * rng.standard_normal((2, flights)))
        first, second = np.where(rng.random((2, flights)) < losses, 40.0, pair)
        difference = paired_difference(second, first, risk, rng, 400)
        words[classify_difference(float(risk.apply(first)), *map(float, difference))] += 1
    return words


@pytest.mark.parametrize("risk", [Risk("mean"), Risk("cvar", 0.8)], ids=str)
@pytest.mark.parametrize(("spread", "losses"), [(0.5, 0.0), (0.5, 0.01)], ids=["skewed", "with rare costly losses"])
def test_flights_without_a_difference_are_seldom_called_better(risk, spread, losses):
    words = words_without_difference(risk, spread, losses, 64, REPEATS)
    # Of 400 with 2.5 %, 19 or more come in one case of 150. By the studentized interval alone it is 18 to 32.
    assert max(words[BETTER], words[WORSE]) < 19


def test_flights_that_are_alike_have_no_practical_difference():
    words = words_without_difference(Risk("mean"), 0.02, 0.0, 256, 100)
    assert words[NO_PRACTICAL_DIFFERENCE] == 100


def test_a_difference_that_matters_is_found():
    words = Counter()
    for k in range(100):
        rng = generator(1, "test/difference", k)
        first, second = np.exp(0.5 * rng.standard_normal(FLIGHTS) + 0.1 * rng.standard_normal((2, FLIGHTS)))
        difference = paired_difference(0.9 * second, first, Risk("mean"), rng, 400)
        words[classify_difference(float(first.mean()), *map(float, difference))] += 1
    assert words[BETTER] > 95


def tables(n):
    """Discordant flights of either (2, tables) of n flights."""
    pairs = np.array([(i, j) for i in range(n + 1) for j in range(n + 1 - i)])
    return pairs[:, 0], pairs[:, 1]


@pytest.mark.parametrize("n", [32, 64])
@pytest.mark.parametrize("rate", [0.002, 0.01, 0.02, 0.05, 0.1, 0.3, 0.6])
def test_shares_without_a_difference_are_called_better_in_at_most_2_5_per_cent(rate, n):
    """rate: of flights that end differently, half of them for either; probabilities are summed, nothing is drawn."""
    first, second = tables(n)
    counts = np.column_stack([first, second, n - first - second])
    weights = multinomial.pmf(counts, n, [rate / 2, rate / 2, 1.0 - rate])
    _, high = share_difference(first, second, n)
    assert weights[high < 0.0].sum() <= 0.025
    # By the test itself: half the probability of what was seen, and all of what is more extreme.
    lost = first + second
    mid_p = binom.cdf(first, lost, 0.5) - 0.5 * binom.pmf(first, lost, 0.5)
    assert np.array_equal(high < 0.0, (mid_p < 0.025) & (lost > 0))


def test_the_test_of_shares_finds_more_than_two_exact_intervals():
    # Five of five, p = 1/32: mid-p 1/64 = 0.0156 on the side of it; the product of exact intervals held 0 up to seven of seven.
    assert share_difference(0, 5, 256).high < 0.0 < share_difference(0, 4, 256).high
