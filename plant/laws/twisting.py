"""The super-twisting term w and its generalisation, sampled without chatter.

    w = -k1 phi1(S) + v,   v' = -k2 phi2(S)
    phi1 = |S|^(1/2) sgn S + mu S,   phi2 = 2 phi1 phi1' = sgn S + 3 mu |S|^(1/2) sgn S + 2 mu^2 S

It drives S' = w + d to S = S' = 0 in finite time. mu = 0: A. Levant, "Sliding order and sliding accuracy in sliding mode
control", Int. J. Control 58(6), 1993; exact for every d with |d'| <= L where k2 > L and k1^2 > k2 + L (R. Seeber, M. Horn,
Automatica 84, 2017). mu > 0: J. A. Moreno, "A linear framework for the robust stability analysis of a generalized
super-twisting algorithm", CCE 2009, whose k2 is twice this one; its linear parts also meet a d that grows with S.

Sampled implicitly, so that the term does not chatter whatever the gains: it acts on z, the solution of

    z + h k1 phi1(z) + h^2 k2 phi2(z) = S   with any number xi of [-1, 1] for sgn 0

and w = (z - S)/h + v, v being updated first. Inside the band |S| <= h^2 k2 that is z = 0 and xi = S/(h^2 k2), outside it is
quadratic in |z|^(1/2). Then |S| <= L h^2 once arrived, and w travels no further than d; explicit Euler steps swing about both
ever more with growing gains. The scheme is our own derivation. It is not for free: inside the band the gain on S is 2/h.

Windup: what saturation keeps from the term's pull on S is not integrated either.
"""

from typing import Any, NamedTuple

from plant.laws.law import Nonlinearity
from plant.primitives import absolute, clip, maximum, sign, sqrt

SAMPLING = "super-twisting term: implicit Euler, without chatter"


class TwistConstants(NamedTuple):
    """h [s], k1 [y^(1/2) s^(-3/2)], k2 [y/s3], mu [(s/y)^(1/2)]; band: h^2 k2 [y/s]; per_band: its inverse, or large."""

    h: float
    k1: float
    k2: float
    mu: float
    band: float
    per_band: float


class Twist(NamedTuple):
    """v [y/s2]; of the last period: pull, v before its update minus w [y/s2]; switching, the switching term [y/s3]."""

    v: float
    pull: float
    switching: float


def twist_constants(k1: float, k2: float, mu: float, h: float) -> TwistConstants:
    """Work out the band in which z = 0."""
    band = h * h * k2
    return TwistConstants(h, k1, k2, mu, band, 1.0 / maximum(band, 1e-30))


def positive_root(square: float, linear: float, right: float) -> float:
    """Return the root y >= 0 of square y^2 + linear y = right: right >= 0, linear > 0, no cancellation."""
    return 2.0 * right / (linear + sqrt(linear * linear + 4.0 * square * right))


def phi2(xi: float, y: float, sgn: float, mu: float) -> float:
    """phi2 at |z| = y^2 with the sign sgn; xi: what sgn z represents, any number of [-1, 1] at z = 0."""
    return xi + sgn * mu * y * (3.0 + 2.0 * mu * y)


def root_size(s: float, t: TwistConstants) -> float:
    """|z|^(1/2) of the solution z for S = s."""
    square = 1.0 + t.h * t.mu * (t.k1 + 2.0 * t.h * t.k2 * t.mu)
    linear = t.h * (t.k1 + 3.0 * t.h * t.k2 * t.mu)
    return positive_root(square, linear, maximum(absolute(s) - t.band, 0.0))


def switching_term(s: float, constants: Any) -> float:
    """k2 phi2 [y/s3]: minus v'; constants hold the part `twist`."""
    t = constants.twist
    return t.k2 * phi2(clip(s * t.per_band, -1.0, 1.0), root_size(s, t), sign(s), t.mu)


def root_term(s: float, constants: Any) -> float:
    """k1 phi1 + h k2 phi2 = (S - z)/h [y/s2]: what w falls short of the updated v; constants hold the part `twist`."""
    t = constants.twist
    y = root_size(s, t)
    return t.k1 * sign(s) * y * (1.0 + t.mu * y) + t.h * switching_term(s, constants)


def undelivered(pull: float, excess: float) -> float:
    """Return the share of the pull, 0 to 1, that saturation kept from the last w [y/s2]."""
    return clip(excess * pull / maximum(pull * pull, 1e-30), 0.0, 1.0)


def super_twisting(memory: Twist, s: float, excess: float, constants: Any) -> tuple[float, Twist]:
    """Return w [y/s2] for S = s; excess: what of the last w was delivered beyond what was asked for, 0 without saturation."""
    h = constants.twist.h
    before = memory.v + h * memory.switching * undelivered(memory.pull, excess)
    switching = switching_term(s, constants)
    v = before - h * switching
    w = v - root_term(s, constants)
    return w, Twist(v, before - w, switching)


NONLINEAR = (
    Nonlinearity("root term", root_term, "{y}/s"),
    Nonlinearity("switching term", switching_term, "{y}/s"),
)
