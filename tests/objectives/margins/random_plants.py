"""Plants drawn at random under PID controllers, and their loops as sampled by SciPy: none of the product's own code.

A plant has a slow part, stable, free or unstable, and two modes of up to 0.8 of half the sampling rate, damped by 0.003 to 0.7;
its input may be late and lag, and its controller may step slower than the control period, alone or over a faster one.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import cont2discrete

KINDS = ("every period", "every few periods", "cascade")


@dataclass(frozen=True)
class Draw:
    """A plant and its controller.

    parameters: of `tests.plant.model.modal`; h: control period [s]; delay: periods; lag [s], 0 for none; every: periods of the
    outer controller; gains: kp, ki, kd and t_f of it, then those of the inner one in a cascade.
    """

    kind: str
    parameters: dict[str, float]
    h: float
    delay: int
    lag: float
    every: int
    gains: tuple[float, ...]

    @property
    def resonances(self) -> np.ndarray:
        """Frequencies [rad/s] of the modes with their width."""
        p = self.parameters
        return np.array([[p[f"{n}_frequency"], p[f"{n}_damping"]] for n in ("first", "second")])

    def outer_loop(self) -> tuple[Any, float]:
        """Return the loop transfer function of the outer controller of z, and its period [s]."""
        step = self.every * self.h
        if self.kind == "cascade":
            a, b, c = self._under_inner()
            whole, driven = a, b
            for _ in range(self.every - 1):
                whole, driven = a @ whole, a @ driven + b
            return lambda z: pid(self.gains[:4], step, z) * response(whole, driven, c[0], z), step
        a, b, c = self._late(step)
        return lambda z: pid(self.gains, step, z) * response(a, b, c[0], z), step

    def radius(self) -> float:
        """Spectral radius of the closed loop over the period of the outer controller."""
        step = self.every * self.h
        if self.kind == "cascade":
            a, b, c = self._under_inner()
            whole, driven = a, b
            for _ in range(self.every - 1):
                whole, driven = a @ whole, a @ driven + b
            a, b = whole, driven
        else:
            a, b, c = self._late(step)
        law = pid_states(self.gains[:4], step)
        return float(np.abs(np.linalg.eigvals(closed(a, b, c[0], law))).max())

    def _matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        p = self.parameters
        a, b, c = np.zeros((6, 6)), np.zeros((6, 1)), np.zeros((2, 6))
        a[:2, :2], b[1] = [[0.0, 1.0], [-p["stiffness"], -p["friction"]]], 1.0
        for i, n in ((2, "first"), (4, "second")):
            w, zeta = p[f"{n}_frequency"], p[f"{n}_damping"]
            a[i : i + 2, i : i + 2], b[i + 1] = [[0.0, 1.0], [-w * w, -2.0 * zeta * w]], p[f"{n}_share"]
        c[0, ::2], c[1, 1::2] = 1.0, 1.0
        if self.lag > 0.0:
            a = np.block([[a, b], [np.zeros((1, 6)), np.array([[-1.0 / self.lag]])]])
            b, c = np.append(np.zeros(6), 1.0 / self.lag)[:, None], np.hstack([c, np.zeros((2, 1))])
        return a, b, c

    def _sampled(self, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        a, b, c = self._matrices()
        sampled: Any = cont2discrete((a, b, c, np.zeros((2, 1))), step)
        return sampled[0], sampled[1], c

    def _late(self, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The plant sampled with a command that comes into force `delay` periods late: whole steps in a queue, and the rest."""
        whole, rest = divmod(self.delay * self.h, step)
        whole, rest = (
            (int(whole) + 1, 0.0) if step - rest < 1e-9 * step else (int(whole), rest if rest > 1e-9 * step else 0.0)
        )
        a, b_new, c = self._sampled(step - rest)
        b_old = np.zeros_like(b_new)
        if rest > 0.0:
            before, b_before, _ = self._sampled(rest)
            b_old, a = a @ b_before, a @ before
        n, q = len(a), whole + (rest > 0.0)
        if q == 0:
            return a, b_new, c
        big, drive = np.zeros((n + q, n + q)), np.zeros((n + q, 1))
        big[:n, :n] = a
        # The queue: the newest command first; the one in force from the start of the step is the last.
        big[n + 1 :, n : n + q - 1] = np.eye(q - 1)
        drive[n] = 1.0
        if rest > 0.0:
            big[:n, [n + q - 1]] = b_old
            if q > 1:
                big[:n, [n + q - 2]] += b_new
            else:
                drive[:n] += b_new
        else:
            big[:n, [n + q - 1]] = b_new
        return big, drive, np.hstack([c, np.zeros((2, q))])

    def _under_inner(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The plant with its speed held by the inner controller, from the set point of that."""
        a, b, c = self._late(self.h)
        f, g, k, d = pid_states(self.gains[4:], self.h)
        m = len(f)
        whole = np.block([[a + b @ (d[:, 1:] @ c[[1]]), b @ k], [g[:, 1:] @ c[[1]], f]])
        return whole, np.vstack([b @ d[:, :1], g[:, :1]]), np.hstack([c, np.zeros((2, m))])


def pid(gains, h, z):
    """PID of the measured output with forward-Euler integral and filtered difference, of z."""
    kp, ki, kd, t_f = gains
    share = 1.0 - np.exp(-h / t_f) if t_f > 0.0 else 1.0
    return kp + ki * h / (z - 1.0) + kd * share * (z - 1.0) / (h * (z - (1.0 - share)))


def pid_states(gains, h):
    """The same as states (integral, filtered rate, last value) from set point and measurement to the command."""
    kp, ki, kd, t_f = gains
    share = 1.0 - np.exp(-h / t_f) if t_f > 0.0 else 1.0
    rate = np.array([0.0, 1.0 - share, -share / h])
    a = np.array([[1.0, 0.0, 0.0], rate, [0.0, 0.0, 0.0]])
    b = np.array([[ki * h, -ki * h], [0.0, share / h], [0.0, 1.0]])
    return a, b, np.array([[1.0, 0.0, 0.0] - kd * rate]), np.array([[kp, -kp - kd * share / h]])


def closed(a, b, c, law):
    """State matrix of a sampled plant with output c under a law."""
    f, g, k, d = law
    c = c[None]
    return np.block([[a + b @ (d[:, 1:] @ c), b @ k], [g[:, 1:] @ c, f]])


def response(a, b, c, z):
    """Response of a sampled system at points z."""
    z = np.asarray(z, dtype=complex)
    solved = np.linalg.solve(np.atleast_1d(z)[:, None, None] * np.eye(len(a)) - a, b[None].astype(complex))
    return (solved[..., 0] @ c).reshape(z.shape)


def drawn(number: int) -> Draw:
    """Return plant `number` with a controller that holds it, its largest sensitivity between 1.15 and 4."""
    draw = np.random.default_rng([2029, number])
    kind = KINDS[0] if number % 4 < 2 else KINDS[number % 4 - 1]
    h = float(10.0 ** draw.uniform(-3.0, -1.0))
    every = 1 if kind == KINDS[0] else int(draw.integers(2, 5))
    while True:
        found = _candidate(draw, kind, h, every)
        loop, step = found.outer_loop()
        if found.radius() < 0.9999:
            largest = np.max(1.0 / np.abs(1.0 + loop(np.exp(1j * grid(found, step, 300) * step))))
            if 1.15 < largest < 4.0:
                return found


def _candidate(draw: np.random.Generator, kind: str, h: float, every: int) -> Draw:
    # The slow part: poles +-a, +-ja, with friction of any sign, a quarter unstable.
    slow = draw.uniform(0.01, 0.15) / (h * every)
    sort = draw.integers(4)
    stiffness = [0.0, slow**2, -(slow**2), slow**2][sort]
    friction = [slow, 2.0 * draw.uniform(0.05, 1.0) * slow, 0.3 * slow, -0.2 * slow][sort]
    frequencies = np.sort(draw.uniform(0.1, 0.8, 2)) * np.pi / h
    damping = np.exp(draw.uniform(np.log(0.003), np.log(0.7), 2))
    shares = draw.choice([-1.0, 1.0], 2) * np.exp(draw.uniform(np.log(0.03), np.log(1.0), 2))
    parameters = {"stiffness": stiffness, "friction": friction}
    for name, w, zeta, share in zip(("first", "second"), frequencies, damping, shares, strict=True):
        parameters |= {f"{name}_frequency": float(w), f"{name}_damping": float(zeta), f"{name}_share": float(share)}
    delay, lag = int(draw.integers(0, 4)), float(draw.choice([0.0, draw.uniform(0.2, 3.0) * h]))
    fast = draw.uniform(0.5, 3.0) * slow
    kp, zeta = fast**2, draw.uniform(0.5, 2.0)
    kp, ki, kd = kp + max(-stiffness, 0.0), draw.uniform(0.0, 0.2) * kp * fast, 2.0 * zeta * fast + max(-friction, 0.0)
    t_f = float(draw.choice([0.0, draw.uniform(0.5, 4.0) * h * every]))
    if kind != "cascade":
        return Draw(kind, parameters, h, delay, lag, every, (kp, ki, kd, t_f))
    outer = (kp / kd, ki / kd, 0.0, 0.0)
    return Draw(kind, parameters, h, delay, lag, every, (*outer, kd, draw.uniform(0.0, 0.2) * kd * fast, 0.0, 0.0))


def grid(draw: Draw, step: float, points: int = 2000) -> np.ndarray:
    """Frequencies (f,) [rad/s] up to pi/step, close about the modes, those beyond folded back."""
    top = np.pi / step
    near = []
    for w, zeta in draw.resonances:
        folded = abs((w + top) % (2.0 * top) - top)
        width = np.maximum(zeta, 1e-3) * w
        near.append(
            folded
            + width * np.concatenate([-np.geomspace(1e-3, 10.0, points // 8), np.geomspace(1e-3, 10.0, points // 8)])
        )
    w = np.unique(np.concatenate([np.geomspace(1e-5 * top, top, points), *near]))
    return w[(w > 0.0) & (w <= top)]
