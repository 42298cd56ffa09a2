"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.certificates"
EXTENSION = Extension(
    name="certificates",
    about="Numbers proved about an axis of a controller by matrix inequalities.",
    certificates={
        "quadrotor": f"{HOME}.rows:certificate_rows",
        "plant": f"{HOME}.plant_rows:plant_certificate_rows",
    },
)
