"""Certificates by name.

For a screen or a command: `axis_loop(cascade, row, nominal, timing, axis)` describes an axis of a gains row, and each entry of
CERTIFICATES that `applies_to` it returns a `Certificate` from `run(axis, ...)`. Importing this takes cvxpy's second.
"""

from tuner.extensions.certificates import circle_criterion, common_lyapunov, peak_gain, supertwisting
from tuner.extensions.certificates.certificate import CertificateInfo

CERTIFICATES: dict[str, CertificateInfo] = {
    module.INFO.name: module.INFO for module in (supertwisting, peak_gain, circle_criterion, common_lyapunov)
}
