"""Units of gains.json: UCUM case-sensitive codes for the spellings that the rest of the tool uses.

The Unified Code for Units of Measure, version 2.1, 2017 (ucum.org). It has no fractional exponents: a unit with a root is
written as an annotation in braces, which UCUM takes for a dimensionless number that a person can read.
"""

from plant.errors import InputError

UCUM = {
    "1": "1", "%": "%", "dB": "dB", "deg": "deg", "byte": "By",
    "kg": "kg", "kg m2": "kg.m2", "N": "N", "N m": "N.m", "N m s": "N.m.s", "N s/m": "N.s/m", "N s2": "N.s2",
    "N s2/m2": "N.s2/m2",
    "s": "s", "Hz": "Hz", "1/s": "s-1", "s^-1": "s-1", "s^-2": "s-2", "s^-3": "s-3",
    "m": "m", "m s": "m.s", "m^2 s": "m2.s", "m/s": "m/s", "m/s2": "m/s2", "m/s^2": "m/s2", "m s^-2": "m/s2",
    "m/s^3": "m/s3", "m s^-3": "m/s3",
    "rad": "rad", "rad s": "rad.s", "rad^2 s": "rad2.s", "rad/s": "rad/s", "rad/s^2": "rad/s2", "rad s^-2": "rad/s2",
    "rad/s^3": "rad/s3", "rad s^-3": "rad/s3",
    "m^(1/2) s^(-3/2)": "{m^0.5.s^-1.5}", "rad^(1/2) s^(-3/2)": "{rad^0.5.s^-1.5}",
    "m^(-1/2) s^(1/2)": "{m^-0.5.s^0.5}", "rad^(-1/2) s^(1/2)": "{rad^-0.5.s^0.5}",
}  # fmt: skip
"""Our spelling -> UCUM code."""


def ucum(unit: str) -> str:
    """Return the UCUM code of a unit in our spelling; raises InputError for one that the table lacks."""
    if unit not in UCUM:
        raise InputError(f"the unit '{unit}' has no UCUM code yet; add it to tuner/gains/ucum.py")
    return UCUM[unit]


def quantity(value: float, unit: str) -> dict[str, float | str]:
    """Return {value, unit} of a number whose unit is in our spelling."""
    return {"value": value, "unit": ucum(unit)}
