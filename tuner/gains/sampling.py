"""How each law family becomes difference equations, in words: a gain means nothing without it on another processor."""

HOLD = "command held over the control period"
PID = (
    f"filtered derivative: pole at exp(-h/Tf); integral: forward Euler, in force one period after it is formed; {HOLD}"
)
LINEAR = f"observer: current estimator for a held input, three poles at exp(-omega_o h); feedback of the same instant; {HOLD}"
NONLINEAR = (
    "tracking differentiator: fhan of the period 5 h; observer: current estimator for a held input with fal corrections, three "
    f"poles at exp(-omega_o h) in the linear zone; feedback of the same instant; {HOLD}"
)
RINGING = (
    "observer: current estimator for a held input, poles at exp(p h) for the roots p of s^3 + 3 wo s^2 + 3 wo^2 s + 3 wo^3; "
    f"feedback of the same instant; {HOLD}"
)
TWISTING = f"super-twisting term: implicit Euler, without chatter; {HOLD}"
EXPLICIT = f"super-twisting term: explicit Euler; {HOLD}"
OBSERVED_TWISTING = (
    "observer: current estimator for a held input, three poles at exp(-omega_o h); super-twisting term: implicit Euler, "
    f"without chatter; {HOLD}"
)

SAMPLING = {
    "pid": PID,
    "ladrc": LINEAR,
    "ladrc_printed": LINEAR,
    "adrc": NONLINEAR,
    "supertwisting": TWISTING,
    "supertwisting_euler": EXPLICIT,
    "hybrid": LINEAR,
    "hybrid_literal": LINEAR,
    "hybrid_paper_f_hat": LINEAR,
    "hybrid_beta3": RINGING,
    "hybrid_true_sta": OBSERVED_TWISTING,
    "hybrid_gsta": OBSERVED_TWISTING,
}
"""Name of a law -> how it is sampled with the control period h."""
