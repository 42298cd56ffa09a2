"""Our own attitude loops as somebody outside flies them: from what an instant of a piloted loop tells, in Python, law by law."""

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Law
from plant.quadrotor.allocation import allocate
from plant.vectors import Vec3

AXES = ("roll", "pitch", "yaw")


class AttitudeOutside:
    """Betaflight's law on three axes; gains: record of the cascade's."""

    def __init__(self, law: Law, gains, nominal, h):
        self.law, self.nominal, self.h, self.memory = law, nominal, h, None
        constants = {axis: law.prepare(getattr(gains, axis), h) for axis in AXES}
        # The pilot has turned the error of the heading into a rate already.
        self.constants = {**constants, "yaw": constants["yaw"]._replace(outer=0.0)}

    def thrusts(self, asked):
        measured = [Measured(angle, rate) for angle, rate in zip(asked.angles, asked.rate, strict=True)]
        if self.memory is None:
            self.memory = {
                axis: self.law.start(self.constants[axis], seen, 0.0) for axis, seen in zip(AXES, measured, strict=True)
            }
        goals = (*(Setpoint(tilt, 0.0, 0.0) for tilt in asked.tilt), Setpoint(0.0, asked.yaw, 0.0))
        torque = []
        for axis, seen, goal, inertia in zip(AXES, measured, goals, self.nominal.vehicle.inertia, strict=True):
            found, self.memory[axis] = self.law.step(
                self.memory[axis],
                self.constants[axis],
                Channel(1.0 / inertia, 0.0),
                goal,
                seen,
                Applied(0.0, 0.0),
                self.h,
            )
            torque.append(found)
        return allocate(4.0 * asked.lift, Vec3(*torque), self.nominal)
