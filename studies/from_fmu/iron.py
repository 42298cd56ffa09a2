"""A soldering iron, which another tool makes an FMU of: `pythonfmu build -f studies/from_fmu/iron.py -d studies/from_fmu`.

A heater warms the tip by conduction; the tip loses heat by convection and radiation, and to the joint that is soldered.
Temperatures are rises above the room [K].
"""

from pythonfmu import Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Real

ROOM = 293.0


class Iron(Fmi2Slave):
    description = "Temperature of a soldering tip"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.power, self.joint = 0.0, 0.0
        self.heater, self.tip = 0.0, 0.0
        self.heater_capacity, self.tip_capacity, self.conduction = 0.8, 2.0, 1.5
        self.convection, self.radiation = 0.1, 4.5e-11
        for name in ("power", "joint"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        self.register_variable(Real("tip", causality=Fmi2Causality.output, initial=Fmi2Initial.exact))
        self.register_variable(Real("heater", causality=Fmi2Causality.local, initial=Fmi2Initial.exact))
        for name in ("heater_capacity", "tip_capacity", "conduction", "convection"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def rates(self, heater, tip):
        flow = self.conduction * (heater - tip)
        lost = self.convection * tip + self.radiation * ((ROOM + tip) ** 4 - ROOM**4) + self.joint
        return (self.power - flow) / self.heater_capacity, (flow - lost) / self.tip_capacity

    def do_step(self, current_time, step_size):
        h, x = step_size, (self.heater, self.tip)
        k1 = self.rates(*x)
        k2 = self.rates(*moved(x, 0.5 * h, k1))
        k3 = self.rates(*moved(x, 0.5 * h, k2))
        k4 = self.rates(*moved(x, h, k3))
        for share, rate in ((h / 6.0, k1), (h / 3.0, k2), (h / 3.0, k3), (h / 6.0, k4)):
            x = moved(x, share, rate)
        self.heater, self.tip = x
        return True


def moved(x, h, rate):
    return tuple(a + h * b for a, b in zip(x, rate, strict=True))
