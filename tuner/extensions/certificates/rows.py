"""Certificates of a quadrotor's axes as rows of margins.json."""

from functools import cache

from objectives.linear_axis.axis_of_cascade import axis_loop
from plant.loop import Timing
from plant.quadrotor.cascade import AXES
from plant.quadrotor.nominal import nominal
from tuner.documents.margins import CertificateRow
from tuner.extensions.certificates.certificate import Certificate
from tuner.extensions.certificates.registry import CERTIFICATES
from tuner.gains import Controller


def certificate_rows(controller: Controller) -> list[CertificateRow]:
    """Return the certificates of every axis that they apply to; value None where nothing is proved."""
    assumed = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
    timing = Timing(controller.control_period, controller.plant_step)
    loops = {axis: axis_loop(controller.cascade, controller.gains, assumed, timing, axis) for axis in AXES}
    # x and y are mostly one loop, roll and pitch another: each is proved once.
    proved = cache(lambda info, loop: info.run(loop))
    return [
        certificate_row(axis, info.name, info.title, info.source, proved(info, loop))
        for axis, loop in loops.items()
        for info in CERTIFICATES.values()
        if info.applies_to(loop)
    ]


def certificate_row(axis: str, name: str, title: str, source: str, certificate: Certificate) -> CertificateRow:
    """Return a certificate of an axis as a row of margins.json."""
    value, unit, is_verified, why = certificate.value, certificate.unit, certificate.verified, certificate.why
    return CertificateRow(
        axis=axis, name=name, title=title, value=value, unit=unit, verified=is_verified, why=why, source=source
    )
