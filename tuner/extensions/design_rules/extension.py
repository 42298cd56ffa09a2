"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.design_rules.methods"
EXTENSION = Extension(
    name="design_rules",
    about="Design rules of textbooks for plants: SIMC, lambda, AMIGO, Ziegler-Nichols, Herbst's for ADRC, LQR, poles, observers.",
    observers={"observer": "tuner.extensions.design_rules.observing:with_observer"},
    designs={
        "simc": f"{HOME}:SIMC",
        "lambda": f"{HOME}:LAMBDA",
        "amigo": f"{HOME}:AMIGO",
        "ziegler-nichols": f"{HOME}:ZIEGLER_NICHOLS",
        "herbst": f"{HOME}:HERBST",
        "lqr": f"{HOME}:LQR",
        "poles": f"{HOME}:POLES",
    },
)
