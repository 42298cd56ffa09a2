"""Meanings of study keys that are fields of the model's types."""

SENSORS = {
    "position": "RMS of the white noise on each axis of the position [m].",
    "velocity": "RMS of the white noise on each axis of the velocity [m/s].",
    "attitude": "RMS of the white noise on roll, pitch and yaw [rad].",
    "rate": "RMS of the white noise on each axis of the gyro [rad/s]; by default the airframe's gyro_noise, if any.",
    "position_bias": "RMS of a bias of the position that is drawn once a flight [m].",
    "velocity_bias": "RMS of a bias of the velocity that is drawn once a flight [m/s].",
    "attitude_bias": "RMS of a bias of roll, pitch and yaw that is drawn once a flight [rad].",
    "rate_bias": "RMS of a bias of the gyro that is drawn once a flight [rad/s].",
}
SPREAD = {
    "mass": "Half-width of the uniform spread of the mass, as a share of the nominal one; 0.1 for +-10 %.",
    "inertia": "The same of the moments of inertia.",
    "thrust": "The same of the thrust of the rotors at any command.",
    "lag": "The same of the lag of the rotors.",
    "mass_shift": "Distance of the middle of that spread from the nominal mass; mass = mass_shift = 0.15: 0 to 30 % payload.",
    "inertia_shift": "The same of the moments of inertia.",
    "thrust_shift": "The same of the thrust.",
    "lag_shift": "The same of the lag; 1: rotors that are twice as slow.",
    "centre": "Half-width of the uniform offset of the centre of mass along body x and y, as a share of the arm.",
}
SPREAD_FROM = 'Source of the vehicles in place of the other keys: "airframe", for the [uncertainty] of its file.'
BANDS = {
    "settling": "Half-width of the settling band on an axis with a step, as a share of the step.",
    "position": "Half-width of the settling band without a step, and of the recovery band, of x, y and z [m].",
    "attitude": "The same of roll, pitch and yaw [rad].",
}
MISSION = {
    "followed": "Largest RMS error where the reference moves, as a share of that of a flight that never leaves its start.",
    "held": "Largest RMS error where the reference rests, as a share of limits.position; of a channel of a plant of one's own "
    "that an objective or a limit judges, of its limit.",
    "off": "Quantities without an automatic limit: QUANTITY, or QUANTITY@SCENARIO for one scenario.",
}
GUST = {
    "amplitude": "Peak of the gust [m/s], may be negative.",
    "start": "Begin of the gust [s].",
    "length": "Duration of the whole gust [s].",
    "direction": 'Direction: "u" along the mean wind, "v" to its left, "w" up, or three numbers in world axes.',
}
INJECTION = {
    "acceleration_sigma": "Standard deviation of the acceleration along world x, y and z [m/s2].",
    "acceleration_time": "Correlation time of the acceleration [s].",
    "acceleration_bias": "Constant part of the acceleration [m/s2].",
    "angular_sigma": "Standard deviation of the angular acceleration about body x, y and z [rad/s2].",
    "angular_time": "Correlation time of the angular acceleration [s].",
    "angular_bias": "Constant part of the angular acceleration [rad/s2].",
}
AIR = {
    "spec": 'Turbulence specification: "8785C" (MIL-F-8785C) or "1797" (MIL-HDBK-1797).',
    "intensity": '"none", "light", "moderate", "severe", or the wind at 20 ft [m/s].',
    "altitude": "Height above ground of the turbulence [m]; it does not follow the vehicle.",
    "vehicle_speed": "Speed over ground along the mean wind [m/s], negative into the wind; it sets the airspeed only.",
    "minimum_airspeed": "Smallest airspeed of the turbulence [m/s].",
    "wind_direction_deg": "Direction that the mean wind blows to, counter-clockwise from east [deg]; by default drawn.",
    "mean_wind": "Let the mean wind blow on the vehicle, which then starts trimmed against it; false: its turbulence alone.",
    "angular_rates": "Draw gust rates p, q and r too.",
    "span": "Distance from rotor to rotor [m], for the gust rates.",
    "roughness": 'Category of the ground for the profile of the mean wind: "A", "B" (2.0 ft) or "C" (0.15 ft).',
    "window": "Begin and end of turbulence and injected noise [s]; by default the whole flight.",
    "gust": "One raised-cosine pulse of wind.",
    "injection": "Accelerations injected without air.",
}
