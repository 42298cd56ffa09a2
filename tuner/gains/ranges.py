"""The range of every gain, at a control period: what a study, a gains file or an import may give it."""

from plant.errors import InputError
from plant.gains import MOST_OBSERVER, GainAddress


def check_value(key: str, gain: GainAddress, value: float, control_period: float, origin: str = "given") -> None:
    """Refuse a value that a gain cannot have at this control period [s]; key: of the entry that gives it."""
    info, what = gain.info, f"{origin} {value:g} {gain.unit} for {gain.address} ({gain.info.meaning})"
    if value < info.least or (info.exclusive and value == info.least):
        bound = "above" if info.exclusive else "at least"
        raise InputError(f"{what}; it must be {bound} {info.least:g} {gain.unit}", key=key)
    # Relative 1e-9: 75 rad/s at 4 ms is the limit and not above it, whichever way the product rounds.
    if info.observer and value * control_period > MOST_OBSERVER * (1.0 + 1e-9):
        raise InputError(
            f"{what}; at a control period of {control_period:g} s the largest allowed value is "
            f"{MOST_OBSERVER / control_period:g} rad/s (bandwidth times period at most {MOST_OBSERVER}), beyond it the "
            "sampled observer is not the one designed: give a smaller value, or shorten controller.control_period",
            key=key,
        )
