"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.crazyflie"
EXTENSION = Extension(
    name="crazyflie",
    about="Crazyflie: parameters and controllers both ways, its firmware as a judge.",
    requires=("autopilots",),
    targets={"crazyflie": f"{HOME}.export:TARGET"},
    sources={"crazyflie": f"{HOME}.source:SOURCE"},
    firmwares={"crazyflie": f"{HOME}.bench:CRAZYFLIE"},
)
