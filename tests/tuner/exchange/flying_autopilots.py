"""The laws of three autopilots on the rotors of an airframe, from the values of a parameter file, to be differentiated.

Written from the autopilots' sources for these tests alone: FRD axes, rotors by their places, thrust curves inverted, tilt by atan.
Each `..._torque` gives the torque [N m] in our axes (FLU) for angles [rad], rates [rad/s] and time integrals of the angles [rad s].
"""

import numpy as np

FRD = np.array([1.0, -1.0, -1.0])
G0 = 9.80665


def thrust_of(vehicle, command, curve):
    most = vehicle.thrust_coefficient * vehicle.speed_max**2
    return most * (curve * command**2 + (1.0 - curve) * command)


def motor_command(thrust, model):
    """Undo thrust = model u^2 + (1 - model) u."""
    if model < 1e-12:
        return thrust
    return (model - 1.0 + np.sqrt((1.0 - model) ** 2 + 4.0 * model * thrust)) / (2.0 * model)


def hover_thrust(vehicle, curve, model):
    """Command before the inversion that carries the weight, found by bisection."""
    low, high = 0.0, 1.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        lift = 4.0 * thrust_of(vehicle, motor_command(middle, model), curve)
        low, high = (middle, high) if lift < vehicle.mass * vehicle.gravity else (low, middle)
    return 0.5 * (low + high)


def torque_on(vehicle, commands, curve, model):
    """Sum r x F of the rotors and their reaction torques, in FLU."""
    total = np.zeros(3)
    for i, command in enumerate(commands):
        thrust = thrust_of(vehicle, motor_command(command, model), curve)
        place = np.array([vehicle.rotor_x[i], vehicle.rotor_y[i], 0.0])
        total += np.cross(place, [0.0, 0.0, thrust]) + [0.0, 0.0, vehicle.spin[i] * vehicle.torque_ratio * thrust]
    return total


def px4_allocation(vehicle):
    """Motor commands for one unit of roll, pitch, yaw: least-norm solution, normalised."""
    columns = []
    for i in range(4):
        place = np.array([vehicle.rotor_x[i], -vehicle.rotor_y[i], 0.0])
        km = vehicle.torque_ratio if vehicle.spin[i] < 0.0 else -vehicle.torque_ratio
        axis = np.array([0.0, 0.0, -1.0])
        columns.append(np.concatenate((np.cross(place, axis) - km * axis, axis)))
    effect = np.array(columns).T
    mix = np.array([np.linalg.lstsq(effect, unit, rcond=None)[0] for unit in np.eye(6)[:3]]).T
    count = (np.abs(mix) > 1e-3).sum(axis=0)
    rms = np.sqrt((mix**2).sum(axis=0) / (count / 2.0))
    return mix / np.array([max(rms[0], rms[1]), max(rms[0], rms[1]), mix[:, 2].max()])


def angle_clockwise_from_nose(vehicle, i):
    """In degrees; rectangular frames count as an X, whatever their sides, as in AP_MotorsMatrix."""
    x, y = vehicle.rotor_x[i], vehicle.rotor_y[i]
    if abs(x) > 1e-9 and abs(y) > 1e-9:
        x, y = np.sign(x), np.sign(y)
    return np.degrees(np.arctan2(-y, x))


def ardupilot_mix(vehicle):
    mix = []
    for i in range(4):
        angle = np.radians(angle_clockwise_from_nose(vehicle, i))
        mix.append([np.cos(angle + np.pi / 2.0), np.cos(angle), 1.0 if vehicle.spin[i] < 0.0 else -1.0])
    mix = np.array(mix)
    return 0.5 * mix / np.abs(mix).max(axis=0)


# Betaflight's QUADX by place: roll, pitch, yaw; pitch up of the stick is nose down, yaw clockwise.
QUADX = {(-1, -1): (-1, 1, -1), (1, -1): (-1, -1, 1), (-1, 1): (1, 1, 1), (1, 1): (1, -1, -1)}


def betaflight_mix(vehicle):
    return np.array(
        [QUADX[int(np.sign(vehicle.rotor_x[i])), int(np.sign(vehicle.rotor_y[i]))] for i in range(4)], float
    )


def cascade_output(gains, angle, rate, integral):
    """P around PI at rest: integral of (outer (0 - angle) - rate) is -outer integral - angle."""
    outer, p, i = gains
    return p * (outer * -angle - rate) + i * (outer * -integral - angle)


def px4_torque(values, vehicle, curve, angles, rates, integrals):
    model = values["THR_MDL_FAC"]
    out = []
    for k, axis in enumerate(("ROLL", "PITCH", "YAW")):
        scale = values[f"MC_{axis}RATE_K"]
        gains = (values[f"MC_{axis}_P"], scale * values[f"MC_{axis}RATE_P"], scale * values[f"MC_{axis}RATE_I"])
        out.append(cascade_output(gains, FRD[k] * angles[k], FRD[k] * rates[k], FRD[k] * integrals[k]))
    commands = hover_thrust(vehicle, curve, model) + px4_allocation(vehicle) @ out
    return torque_on(vehicle, commands, curve, model)


def ardupilot_torque(values, vehicle, curve, angles, rates, integrals):
    model = values["MOT_THST_EXPO"]
    out = []
    for k, axis in enumerate(("RLL", "PIT", "YAW")):
        gains = (values[f"ATC_ANG_{axis}_P"], values[f"ATC_RAT_{axis}_P"], values[f"ATC_RAT_{axis}_I"])
        out.append(cascade_output(gains, FRD[k] * angles[k], FRD[k] * rates[k], FRD[k] * integrals[k]))
    commands = hover_thrust(vehicle, curve, model) + ardupilot_mix(vehicle) @ out
    return torque_on(vehicle, commands, curve, model)


def betaflight_torque(values, vehicle, curve, angles, rates, integrals, yaw_outer):
    """Degrees throughout; nose down counts as positive pitch."""
    down = np.array([1.0, 1.0, -1.0])
    out = []
    for k, axis in enumerate(("roll", "pitch", "yaw")):
        outer = yaw_outer if axis == "yaw" else values["angle_p_gain"] / 10.0
        i = 0.244381 * values[f"i_{axis}"] * (2.5 if axis == "yaw" else 1.0)
        angle, rate, integral = (np.degrees(down[k] * part[k]) for part in (angles, rates, integrals))
        out.append(cascade_output((outer, 0.032029 * values[f"p_{axis}"], i), angle, rate, integral) / 1000.0)
    commands = hover_thrust(vehicle, curve, 0.0) + betaflight_mix(vehicle) @ out
    return torque_on(vehicle, commands, curve, 0.0)


def attitude_feedback(torque, vehicle):
    """Gains kp, ki, kd (3 axes each) of the angular acceleration, by central differences; and the largest coupling."""
    inertia, step, zero = np.array(vehicle.inertia), 1e-5, np.zeros(3)
    found = []
    coupling = 0.0
    for which in (0, 2, 1):
        matrix = []
        for k in range(3):
            parts = [[zero.copy() for _ in range(3)] for _ in range(2)]
            parts[0][which][k], parts[1][which][k] = step, -step
            matrix.append(-(torque(*parts[0]) - torque(*parts[1])) / (2.0 * step) / inertia)
        matrix = np.array(matrix)
        found.append(np.diag(matrix))
        coupling = max(coupling, np.abs(matrix - np.diag(np.diag(matrix))).max(axis=(0, 1)))
    return np.array(found), coupling


def derivative(function, step=1e-5):
    return (function(step) - function(-step)) / (2.0 * step)


def px4_acceleration_slopes(values, vehicle, curve):
    """What the vehicle accelerates by for 1 m/s2 asked for by PX4's velocity loops: along x, by tilt; along z, by thrust."""
    model = values["THR_MDL_FAC"]

    def along_x(asked):
        return vehicle.gravity * np.tan(np.arctan2(asked, G0))

    def along_z(asked):
        collective = values["MPC_THR_HOVER"] * (asked / G0 + 1.0)
        lift = 4.0 * thrust_of(vehicle, motor_command(collective, model), curve)
        return lift / vehicle.mass - vehicle.gravity

    return derivative(along_x), derivative(along_z)


def by_address(controller):
    from plant.quadrotor.gains import gain_addresses

    return {gain.address: controller.gains[gain.column] for gain in gain_addresses(controller.cascade)}


def attitude_gains(controller):
    held = by_address(controller)
    return np.array([[held[f"{axis}.{name}"] for axis in ("roll", "pitch", "yaw")] for name in ("kp", "ki", "kd")])
