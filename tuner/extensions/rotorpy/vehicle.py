"""Our airframe as parameters of RotorPy's Multirotor, and the plants' differences.

Both have a rigid body, rotors of first order in speed with thrust in its square, and drag that is quadratic in airspeed
at the center of mass. Our drag linear in airspeed is RotorPy's rotor drag at hover: k = d / (4 w_hover), acting at the
rotor hubs, which are therefore put at our center of pressure. S. Folk, J. Paulos, V. Kumar, RotorPy, 2023;
rotorpy/vehicles/multirotor.py, 3.0.0.
"""

from plant.quadrotor.airframes.rules import hover_speed
from plant.quadrotor.battery import has_battery
from plant.quadrotor.features import hears_rotors
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Vec3

# RotorPy's Multirotor has this gravity built in [m/s2].
GRAVITY = 9.81


def hub_damping(vehicle: Vehicle) -> Vec3:
    """Return the damping of body rates by hub drag [N m s]: at hover.

    A hub at (x, y, h) moves with w x r, against which its share of the drag d acts: (d_z y^2 + d h^2, d_z x^2 + d h^2,
    d (x^2 + y^2)), summed over the rotors, with d the mean of d_x and d_y.
    """
    across, up = 0.5 * (vehicle.drag_linear.x + vehicle.drag_linear.y), vehicle.drag_linear.z
    x2, y2 = (0.25 * sum(place * place for place in places) for places in (vehicle.rotor_x, vehicle.rotor_y))
    lever2 = vehicle.drag_height**2
    return Vec3(up * y2 + across * lever2, up * x2 + across * lever2, across * (x2 + y2))


def parameters(vehicle: Vehicle) -> dict[str, float]:
    """Return the scalar parameters in RotorPy's names and units (SI)."""
    around, drag = 4.0 * hover_speed(vehicle), vehicle.drag_linear
    return {
        "mass": vehicle.mass,
        "Ixx": vehicle.inertia.x,
        "Iyy": vehicle.inertia.y,
        "Izz": vehicle.inertia.z,
        "Ixy": 0.0,
        "Iyz": 0.0,
        "Ixz": 0.0,
        "num_rotors": 4,
        "c_Dx": vehicle.drag_quadratic.x,
        "c_Dy": vehicle.drag_quadratic.y,
        "c_Dz": vehicle.drag_quadratic.z,
        "k_eta": vehicle.thrust_coefficient,
        "k_m": vehicle.torque_ratio * vehicle.thrust_coefficient,
        "k_d": 0.5 * (drag.x + drag.y) / around,
        "k_z": drag.z / around,
        "k_h": 0.0,
        "k_flap": 0.0,
        "tau_m": 0.5 * (vehicle.lag_up + vehicle.lag_down),
        "rotor_speed_min": vehicle.speed_min,
        "rotor_speed_max": vehicle.speed_max,
        "motor_noise_std": 0.0,
    }


def differences(vehicle: Vehicle) -> tuple[str, ...]:
    """Return one sentence for each difference between RotorPy's plant and ours."""
    sentences = ["RotorPy integrates with an adaptive step to 1e-3; give Multirotor integrator_kwargs for less."]
    drag = vehicle.drag_linear
    if any(drag):
        damping = ", ".join(f"{part:.3g}" for part in hub_damping(vehicle))
        sentences.append(
            f"The drag linear in airspeed acts at each rotor: it grows with its speed, and damps the rates by {damping} "
            "N m s at hover; ours is that at hover and acts on the body."
        )
    if drag.x != drag.y:
        sentences.append(
            f"RotorPy has one rotor drag along x and y: the mean of {drag.x:g} and {drag.y:g} N s/m is written."
        )
    if any(vehicle.drag_quadratic) and vehicle.drag_height != 0.0:
        sentences.append(
            f"Drag quadratic in airspeed acts at the centre of mass, ours {vehicle.drag_height:g} m above it."
        )
    if vehicle.rotor_inertia > 0.0:
        sentences.append("The gyroscopic torque of the rotors is absent.")
    if any(vehicle.rate_damping):
        sentences.append("The damping of the body rates is absent.")
    if vehicle.lag_up != vehicle.lag_down:
        sentences.append(
            f"RotorPy's rotors have one time constant: the mean of {vehicle.lag_up:g} s up and {vehicle.lag_down:g} s down."
        )
    if vehicle.dead_time > 0.0:
        sentences.append(f"The dead time of the rotors, {vehicle.dead_time:g} s, is absent.")
    if hears_rotors(vehicle) or vehicle.mode_gain or vehicle.gyro_cutoff:
        sentences.append("Rotor lines, frame mode and low-pass of the gyro signal are absent.")
    if has_battery(vehicle):
        sentences.append("The battery is absent: its voltage does not fall.")
    if vehicle.gravity != GRAVITY:
        sentences.append(
            f"RotorPy's gravity is {GRAVITY:g} m/s2, that of the airframe {vehicle.gravity:g} m/s2: it hovers off."
        )
    return tuple(sentences)
