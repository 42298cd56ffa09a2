"""The certificates of every axis of a controller."""

from objectives.certificates import CERTIFICATES, axis_loop
from plant.cascade import AXES
from plant.closed_loop import Timing
from plant.nominal import nominal
from tuner.documents.margins import CertificateRow
from tuner.gains import Controller


def certificate_rows(controller: Controller) -> list[CertificateRow]:
    """Return what each certificate that applies to an axis proves of it; value None where it proves nothing."""
    known = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
    timing = Timing(controller.control_period, controller.plant_step)
    rows = []
    for axis in AXES:
        loop = axis_loop(controller.cascade, controller.gains, known, timing, axis)
        for info in CERTIFICATES.values():
            if info.applies_to(loop):
                found = info.run(loop)
                row = CertificateRow(
                    axis=axis, name=info.name, title=info.title, value=found.value, unit=found.unit,
                    verified=found.verified, why=found.why, source=info.source,
                )  # fmt: skip
                rows.append(row)
    return rows
