"""Certificates: numbers proved about one axis of a controller by matrix inequalities, without flying.

For a screen or a command: `axis_loop(cascade, row, nominal, timing, axis)` describes an axis of a gains row, and each entry of
CERTIFICATES that `applies_to` it returns a `Certificate` from `run(axis, ...)`. Importing this takes cvxpy's second.
"""

from objectives.certificates import circle_criterion, common_lyapunov, peak_gain, supertwisting
from objectives.certificates.axis_of_cascade import axis_loop
from objectives.certificates.certificate import Certificate, CertificateInfo
from objectives.certificates.channel_model import AxisLoop, RotorLag, TiltLoop

__all__ = ["CERTIFICATES", "AxisLoop", "Certificate", "CertificateInfo", "RotorLag", "TiltLoop", "axis_loop"]

CERTIFICATES: dict[str, CertificateInfo] = {
    module.INFO.name: module.INFO for module in (supertwisting, peak_gain, circle_criterion, common_lyapunov)
}
