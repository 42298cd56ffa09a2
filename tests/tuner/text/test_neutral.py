"""Neutral words for plants that are no vehicles; code, choices and names of files stay."""

from tuner.text.markup import Markup
from tuner.text.neutral import neutral, neutral_markup


def test_flights_become_simulations_as_whole_words():
    assert neutral("Flights in the same air; a flight plan of inflight data") == (
        "Simulations under the same disturbance; a simulation plan of inflight data"
    )


def test_code_choices_and_attributes_stay_and_tips_do_not():
    markup = Markup(
        '<p id="flight" data-tip="held-out flights">flown</p><pre>flights</pre><code>flight</code>'
        '<select><option value="flight 1">flight 1</option></select>'
    )
    assert neutral_markup(markup) == (
        '<p id="flight" data-tip="held-out simulations">simulated</p><pre>flights</pre><code>flight</code>'
        '<select><option value="flight 1">flight 1</option></select>'
    )
