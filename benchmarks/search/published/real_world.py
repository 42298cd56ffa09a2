"""Engineering problems of the RE and CRE suites.

R. Tanabe, H. Ishibuchi, "An easy-to-use real-world multi-objective optimization problem suite", Applied Soft Computing
89:106078, 2020, which names the original source of each. A problem REij has i objectives; where the original has constraints, the
sum of their violations is the last objective. A problem CREij keeps the constraints; each is divided by its limit here.
"""

import numpy as np

from benchmarks.search.published.problem import Array

# Areas of reinforcement [in2] that RE22 chooses from.
REINFORCEMENT = np.array(
    [
        0.2,
        0.31,
        0.4,
        0.44,
        0.6,
        0.62,
        0.79,
        0.8,
        0.88,
        0.93,
        1.0,
        1.2,
        1.24,
        1.32,
        1.4,
        1.55,
        1.58,
        1.6,
        1.76,
        1.8,
        1.86,
    ]
    + [2.0, 2.17, 2.2, 2.37, 2.4, 2.48, 2.6, 2.64, 2.79, 2.8, 3.0, 3.08, 3.1, 3.16, 3.41, 3.52, 3.6, 3.72, 3.95, 3.96]
    + [4.0, 4.03, 4.2, 4.34, 4.4, 4.65, 4.74, 4.8, 4.84, 5.0, 5.28, 5.4, 5.53, 5.72, 6.0, 6.16, 6.32, 6.6, 7.11, 7.2]
    + [7.8, 7.9, 8.0, 8.4, 8.69, 9.0, 9.48, 10.27, 11.0, 11.06, 11.85, 12.0, 13.0, 14.0, 15.0]
)


def _unconstrained(*objectives: Array) -> tuple[Array, Array]:
    values = np.column_stack(objectives)
    return values, np.empty((len(values), 0))


def _violation(excesses: list[Array]) -> Array:
    """Return the sum (n,) of the violations of constraints, each (n,) and satisfied at 0 or less."""
    return np.sum(np.maximum(excesses, 0.0), axis=0)


def four_bar_truss(x: Array) -> tuple[Array, Array]:
    """Return volume and displacement of a truss of four bars (RE21)."""
    a, b, c, d = x.T
    root, force, modulus, length = np.sqrt(2.0), 10.0, 2e5, 200.0
    volume = length * (2.0 * a + root * b + np.sqrt(c) + d)
    displacement = force * length / modulus * (2.0 / a + 2.0 * root / b - 2.0 * root / c + 2.0 / d)
    return _unconstrained(volume, displacement)


def reinforced_concrete_beam(x: Array) -> tuple[Array, Array]:
    """Return cost and violation of a concrete beam (RE22)."""
    steel = REINFORCEMENT[np.abs(x[:, :1] - REINFORCEMENT).argmin(axis=1)]
    width, depth = x[:, 1], x[:, 2]
    excesses = [180.0 - steel * depth + 7.735 * steel**2 / width, depth / width - 4.0]
    return _unconstrained(29.4 * steel + 0.6 * width * depth, _violation(excesses))


def pressure_vessel_violation(x: Array) -> tuple[Array, Array]:
    """Return cost and violation of a pressure vessel (RE23)."""
    shell, head = 0.0625 * np.round(x[:, :2].T)
    radius, length = x[:, 2:].T
    cost = 0.6224 * shell * radius * length + 1.7781 * head * radius**2 + 3.1661 * shell**2 * length
    cost += 19.84 * shell**2 * radius
    volume = np.pi * radius**2 * length + 4.0 / 3.0 * np.pi * radius**3
    return _unconstrained(cost, _violation([0.0193 * radius - shell, 0.00954 * radius - head, 1_296_000.0 - volume]))


def hatch_cover(x: Array) -> tuple[Array, Array]:
    """Return weight and violation of a hatch cover (RE24)."""
    flange, height = x.T
    modulus = 700_000.0
    bending, shear = 4500.0 / (flange * height), 1800.0 / height
    deflection = 56.2 * 10_000.0 / (modulus * flange * height**2)
    buckling = modulus * flange**2 / 100.0
    excesses = [bending / 700.0 - 1.0, shear / 450.0 - 1.0, deflection / 1.5 - 1.0, bending / buckling - 1.0]
    return _unconstrained(flange + 120.0 * height, _violation(excesses))


def _two_bar_truss(x: Array) -> tuple[list[Array], list[Array]]:
    a, b, y = x.T
    volume = a * np.sqrt(16.0 + y**2) + b * np.sqrt(1.0 + y**2)
    stress = 20.0 * np.sqrt(16.0 + y**2) / (a * y)
    other_stress = 80.0 * np.sqrt(1.0 + y**2) / (b * y)
    return [volume, stress], [volume - 0.1, stress - 1e5, other_stress - 1e5]


def _disc_brake(x: Array) -> tuple[list[Array], list[Array]]:
    inner, outer, force, surfaces = x.T
    squares, cubes = outer**2 - inner**2, outer**3 - inner**3
    mass = 4.9e-5 * squares * (surfaces - 1.0)
    time = 9.82e6 * squares / (force * surfaces * cubes)
    excesses = [
        20.0 - (outer - inner),
        force / (3.14 * squares) - 0.4,
        2.22e-3 * force * cubes / squares**2 - 1.0,
        900.0 - 2.66e-2 * force * surfaces * cubes / squares,
    ]
    return [mass, time], excesses


def two_bar_truss_violation(x: Array) -> tuple[Array, Array]:
    """Return volume, stress and violation of a truss of two bars (RE31)."""
    objectives, excesses = _two_bar_truss(x)
    return _unconstrained(*objectives, _violation(excesses))


def two_bar_truss(x: Array) -> tuple[Array, Array]:
    """Return volume and stress of a truss of two bars (CRE21), and its constraints."""
    objectives, excesses = _two_bar_truss(x)
    return np.column_stack(objectives), np.column_stack(excesses) / [0.1, 1e5, 1e5]


def disc_brake_violation(x: Array) -> tuple[Array, Array]:
    """Return mass, stopping time and violation of a disc brake (RE33)."""
    objectives, excesses = _disc_brake(x)
    return _unconstrained(*objectives, _violation(excesses))


def disc_brake(x: Array) -> tuple[Array, Array]:
    """Return mass and stopping time of a disc brake (CRE23), and its constraints."""
    objectives, excesses = _disc_brake(x)
    return np.column_stack(objectives), np.column_stack(excesses) / [20.0, 0.4, 1.0, 900.0]


def crashworthiness(x: Array) -> tuple[Array, Array]:
    """Return mass, acceleration and intrusion of a vehicle in a crash (RE34)."""
    a, b, c, d, e = x.T
    mass = 1640.2823 + 2.3573285 * a + 2.3220035 * b + 4.5688768 * c + 7.7213633 * d + 4.4559504 * e
    acceleration = 6.5856 + 1.15 * a - 1.0427 * b + 0.9738 * c + 0.8364 * d - 0.3695 * a * d + 0.0861 * a * e
    acceleration += 0.3628 * b * d - 0.1106 * a**2 - 0.3437 * c**2 + 0.1764 * d**2
    intrusion = -0.0551 + 0.0181 * a + 0.1024 * b + 0.0421 * c - 0.0073 * a * b + 0.024 * b * c - 0.0118 * b * d
    intrusion += -0.0204 * c * d - 0.008 * c * e - 0.0241 * b**2 + 0.0109 * d**2
    return _unconstrained(mass, acceleration, intrusion)


def gear_train(x: Array) -> tuple[Array, Array]:
    """Return error of the ratio, largest gear and violation of a gear train (RE36)."""
    teeth = np.round(x)
    error = np.abs(6.931 - teeth[:, 2] / teeth[:, 0] * teeth[:, 3] / teeth[:, 1])
    return _unconstrained(error, teeth.max(axis=1), _violation([error / 6.931 - 0.5]))


def rocket_injector(x: Array) -> tuple[Array, Array]:
    """Return face temperature, combustion length and tip temperature of a rocket injector (RE37)."""
    a, h, o, p = x.T
    face = 0.692 + 0.477 * a - 0.687 * h - 0.080 * o - 0.0650 * p - 0.167 * a**2 - 0.0129 * h * a + 0.0796 * h**2
    face += -0.0634 * o * a - 0.0257 * o * h + 0.0877 * o**2 - 0.0521 * p * a + 0.00156 * p * h
    face += 0.00198 * p * o + 0.0184 * p**2
    length = 0.153 - 0.322 * a + 0.396 * h + 0.424 * o + 0.0226 * p + 0.175 * a**2 + 0.0185 * h * a - 0.0701 * h**2
    length += -0.251 * o * a + 0.179 * o * h + 0.0150 * o**2 + 0.0134 * p * a + 0.0296 * p * h
    length += 0.0752 * p * o + 0.0192 * p**2
    tip = 0.370 - 0.205 * a + 0.0307 * h + 0.108 * o + 1.019 * p - 0.135 * a**2 + 0.0141 * h * a + 0.0998 * h**2
    tip += 0.208 * o * a - 0.0301 * o * h - 0.226 * o**2 + 0.353 * p * a - 0.0497 * p * o - 0.423 * p**2
    tip += 0.202 * h * a**2 - 0.281 * o * a**2 - 0.342 * h**2 * a - 0.245 * h**2 * o + 0.281 * o**2 * h
    tip += -0.184 * p**2 * a - 0.281 * h * a * o
    return _unconstrained(face, length, tip)


def welded_beam(x: Array) -> tuple[Array, Array]:
    """Return cost and deflection of a welded beam (CRE22), and its constraints."""
    weld, length, height, width = x.T
    load, overhang, modulus, shear_modulus = 6000.0, 14.0, 30e6, 12e6
    cost = 1.10471 * weld**2 * length + 0.04811 * height * width * (14.0 + length)
    deflection = 4.0 * load * overhang**3 / (modulus * width * height**3)
    half = (weld + height) / 2.0
    radius = np.sqrt(length**2 / 4.0 + half**2)
    inertia = 2.0 * np.sqrt(2.0) * weld * length * (length**2 / 12.0 + half**2)
    torsion = load * (overhang + length / 2.0) * radius / inertia
    direct = load / (np.sqrt(2.0) * weld * length)
    shear = np.sqrt(direct**2 + direct * torsion * length / radius + torsion**2)
    bending = 6.0 * load * overhang / (width * height**2)
    buckling = 4.013 * modulus * height * width**3 / 6.0 / overhang**2
    buckling = buckling * (1.0 - height / (2.0 * overhang) * np.sqrt(modulus / (4.0 * shear_modulus)))
    excesses = [shear / 13_600.0 - 1.0, bending / 30_000.0 - 1.0, weld - width, 1.0 - buckling / load]
    return np.column_stack([cost, deflection]), np.column_stack(excesses)


def speed_reducer(x: Array) -> tuple[Array, Array]:
    """Return weight and stress of a speed reducer (CRE24), and its constraints."""
    face, module, _, first, second, thin, thick = x.T
    teeth = np.round(x[:, 2])
    weight = 0.7854 * face * module**2 * (10.0 * teeth**2 / 3.0 + 14.933 * teeth - 43.0934)
    weight += -1.508 * face * (thin**2 + thick**2) + 7.477 * (thin**3 + thick**3)
    weight += 0.7854 * (first * thin**2 + second * thick**2)
    stress = np.sqrt((745.0 * first / (module * teeth)) ** 2 + 1.69e7) / (0.1 * thin**3)
    other_stress = np.sqrt((745.0 * second / (module * teeth)) ** 2 + 1.575e8) / (0.1 * thick**3)
    excesses = [
        27.0 / (face * module**2 * teeth) - 1.0,
        397.5 / (face * module**2 * teeth**2) - 1.0,
        1.93 * first**3 / (module * teeth * thin**4) - 1.0,
        1.93 * second**3 / (module * teeth * thick**4) - 1.0,
        module * teeth / 40.0 - 1.0,
        face / module / 12.0 - 1.0,
        1.0 - face / module / 5.0,
        (1.5 * thin + 1.9 - first) / 1.9,
        (1.1 * thick + 1.9 - second) / 1.9,
        stress / 1300.0 - 1.0,
        other_stress / 1100.0 - 1.0,
    ]
    # The shafts are long enough for their bearings: first >= 1.5 thin + 1.9.
    return np.column_stack([weight, stress]), np.column_stack(excesses)


def side_impact(x: Array) -> tuple[Array, Array]:
    """Return weight, pubic force and mean velocity of a car in a side impact (CRE31), and its constraints."""
    a, b, c, d, e, f, g = x.T
    weight = 1.98 + 4.9 * a + 6.67 * b + 6.98 * c + 4.01 * d + 1.78 * e + 0.00001 * f + 2.73 * g
    force = 4.72 - 0.5 * d - 0.19 * b * c
    pillar = 10.58 - 0.674 * a * b - 0.67275 * b
    door = 16.45 - 0.489 * c * g - 0.843 * e * f
    upper = 0.261 - 0.0159 * a * b - 0.06486 * a - 0.019 * b * g + 0.0144 * c * e + 0.0154464 * f
    middle = 0.214 + 0.00817 * e - 0.0587118 * a + 0.03099 * b * f - 0.018 * b * g + 0.030408 * c
    middle += -0.00364 * e * f - 0.018 * b**2
    limited = [
        (1.16 - 0.3717 * b * d - 0.0092928 * c, 1.0),
        (upper, 0.32),
        (middle, 0.32),
        (0.74 - 0.61 * b - 0.031296 * c - 0.031872 * g + 0.227 * b**2, 0.32),
        (28.98 + 3.818 * c - 4.2 * a * b + 1.27296 * f - 2.68065 * g, 32.0),
        (33.86 + 2.95 * c - 5.057 * a * b - 3.795 * b - 3.4431 * g + 1.45728, 32.0),
        (46.36 - 9.9 * b - 4.4505 * a, 32.0),
        (force, 4.0),
        (pillar, 9.9),
        (door, 15.7),
    ]
    excesses = [value / limit - 1.0 for value, limit in limited]
    return np.column_stack([weight, force, (pillar + door) / 2.0]), np.column_stack(excesses)
