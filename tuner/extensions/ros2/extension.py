"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="ros2",
    about="Parameters of ros2_control's PID controller.",
    requires=("autopilots",),
    targets={"ros2": "tuner.extensions.ros2.export:TARGET"},
)
