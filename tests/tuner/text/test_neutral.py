"""Neutral words for plants that are no vehicles; code, choices and names of files stay."""

from tuner.text.markup import Markup
from tuner.text.neutral import Neutral


def test_flights_become_simulations_as_whole_words():
    assert Neutral().text("Flights in the same air; a flight plan of inflight data") == (
        "Simulations under the same disturbance; a simulation plan of inflight data"
    )


def test_code_choices_and_attributes_stay_and_tips_do_not():
    markup = Markup(
        '<p id="flight" data-tip="held-out flights">flown</p><pre>flights</pre><code>flight</code>'
        '<select><option value="flight 1">flight 1</option></select>'
    )
    assert Neutral().markup(markup) == (
        '<p id="flight" data-tip="held-out simulations">simulated</p><pre>flights</pre><code>flight</code>'
        '<select><option value="flight 1">flight 1</option></select>'
    )


def test_names_of_the_user_stay_longest_first():
    neutral = Neutral(["flight", "flight deck <a>", "tank"])
    assert neutral.text("flight deck <a>: 3 flights of flight") == "flight deck <a>: 3 simulations of flight"
    markup = Markup('<p data-tip="flight deck &lt;a&gt; flown">flight deck &lt;a&gt;, flown in air</p>')
    assert neutral.markup(markup) == (
        '<p data-tip="flight deck &lt;a&gt; simulated">flight deck &lt;a&gt;, simulated in air</p>'
    )
