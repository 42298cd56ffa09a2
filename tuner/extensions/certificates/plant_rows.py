"""Certificates of a plant's loops, by channel, with their assumptions.

The plant is the user's own.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from objectives.linear_axis.channel_model import MODELLED, closed_loop, is_stable
from objectives.margins.describing import Case
from plant.law_registry import law
from plant.records import paths
from tuner.analysis.margins.readings import PlantSubject
from tuner.documents.margins import CertificateRow
from tuner.extensions.certificates.certificate import Certificate, inconclusive
from tuner.extensions.certificates.linear_bound import smallest_sum
from tuner.extensions.certificates.peak_gain import disturbed
from tuner.extensions.certificates.plant_axis import PlantAxis
from tuner.extensions.certificates.registry import CERTIFICATES
from tuner.extensions.certificates.rows import certificate_row
from tuner.extensions.certificates.supertwisting import RATE_UNIT, largest_rate

ASSUMPTIONS = "assumptions"
"""Name of the row of a channel of which no certificate speaks, with the assumption that fails."""
SMALL = Case(0.0)


def plant_certificate_rows(subject: PlantSubject) -> list[CertificateRow]:
    """Return the certificates of every channel; value None with the reason where nothing is proved."""
    return [row for name in subject.system.plan.names for row in _rows(subject, name)]


def _rows(subject: PlantSubject, name: str) -> Iterator[CertificateRow]:
    # Of a plant that knows no disturbances its inputs.
    system = subject.system
    pushes = paths(system.plant.Disturbance) or [actuator.name for actuator in system.plan.actuators]
    axes = [PlantAxis(subject.system, tuple(map(float, subject.row)), name, push) for push in pushes]
    law_name, on_rates = axes[0].law, CERTIFICATES["supertwisting"]
    if law_name in on_rates.laws and system.has_equations and system.plan.observer is None:
        yield certificate_row(name, on_rates.name, on_rates.title, on_rates.source, supertwisting(axes[0]))
        if law_name not in MODELLED:
            return
    why = axes[0].refused(peak_of(subject, name))
    if why:
        title = "what every certificate rests on"
        yield certificate_row(name, ASSUMPTIONS, title, "", inconclusive("1", f"nothing is proved: {why}"))
        return
    for info in CERTIFICATES.values():
        if law_name in info.laws and info.name in PROOFS:
            for axis in axes if info.name == "peak_gain" else axes[:1]:
                certificate = PROOFS[info.name](axis)
                yield certificate_row(name, info.name, TITLES.get(info.name, info.title), info.source, certificate)


def peak_of(subject: PlantSubject, name: str) -> float:
    """Return the sampled Ms of a channel for small signals.

    It is the peak on the grid of the channel's margins, infinite where the channel is not stable.
    """
    if not subject.margins.stable[0, subject.place(name)]:
        return float("inf")
    return float(np.abs(1.0 + subject.model.loop(subject.row, name, SMALL).t).max(axis=0))


def peak_gain(axis: PlantAxis) -> Certificate:
    """Certify where |output| ends for each unit of a disturbance."""
    bound, plant = bound_of(axis), axis.system.plant
    kind = "Disturbance" if axis.disturbance in paths(plant.Disturbance) else "Input"
    unit = per(plant.unit(f"Output.{axis.channel.output}"), plant.unit(f"{kind}.{axis.disturbance}"))
    why = f"|{axis.channel.output}| ends within this times the size of {axis.disturbance}, whatever that does"
    return Certificate(bound.value, unit, bound.verified, why if bound.verified else bound.why, bound.data)


def per(unit: str, other: str) -> str:
    """Return the unit of a quantity for each of another."""
    return unit if other == "1" else f"{unit}/{other}" if other.isalnum() else f"{unit}/({other})"


def bound_of(axis: PlantAxis) -> Certificate:
    """Return the ultimate bound of the output, direct feedthrough included.

    The law decides the method.
    """
    loop, at_once = disturbed(axis), abs(float(closed_loop(axis).d[0, 1]))
    if loop.kappa > 0.0 or not is_stable(loop.a):
        certificate = CERTIFICATES["peak_gain"].run(axis)
        return certificate if certificate.value is None else replace(certificate, value=certificate.value + at_once)
    bound = smallest_sum(loop)
    if bound is None:
        return inconclusive("", "the eigenvalues confirmed no ellipsoid")
    return Certificate(bound + at_once, "", True, "")


def supertwisting(axis: PlantAxis) -> Certificate:
    """Certify the largest disturbance rate of a plant of relative degree two.

    The command moves the second derivative of the output at once.
    """
    unit = RATE_UNIT.replace("{y}", axis.system.plant.unit(f"Output.{axis.channel.output}"))
    if not axis.gain > 0.0:
        return inconclusive(
            unit, "S' = u + d asks for an input that moves the output's acceleration at once, with the sign of b0"
        )
    term = law(axis.law).super_twisting
    assert term is not None, axis.law
    largest = largest_rate(axis.gain * getattr(axis.gains, term.k1), axis.gain * getattr(axis.gains, term.k2))
    return Certificate(largest.value, unit, largest.verified, largest.why, largest.data)


def common_lyapunov(axis: PlantAxis) -> Certificate:
    """Certify the largest spread of a plant's gain from the channel's command."""
    spread = CERTIFICATES["common_lyapunov"].run(axis, varied=("inertia",))
    if not spread.verified:
        return inconclusive(spread.unit, "the plant as assumed does not decay")
    why = "one Lyapunov function holds while the plant answers with 1/(1 + x) to 1/(1 - x) of the gain assumed, x this"
    return Certificate(spread.value, spread.unit, True, why, spread.data)


PROOFS: dict[str, Callable[[PlantAxis], Certificate]] = {
    "peak_gain": peak_gain,
    "circle_criterion": lambda axis: CERTIFICATES["circle_criterion"].run(axis),
    "common_lyapunov": common_lyapunov,
}
"""Certificate on matrices -> how it speaks of a channel of a plant, by its name in CERTIFICATES."""
TITLES = {"common_lyapunov": "largest spread of the gain of the command with one Lyapunov function"}
