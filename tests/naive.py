"""Reference implementations: simple, slow loops over all pairs, written from the equations.

Every fast kernel is tested against them.
"""

import itertools
import math
from fractions import Fraction

import numpy as np


def pairs_within(positions, reach):
    """All (i, j), i < j, nearer than ``reach``."""
    return {
        (i, j)
        for i, j in itertools.combinations(range(len(positions)), 2)
        if math.dist(positions[i], positions[j]) < reach
    }


class Contact:
    """Memory of one contact."""

    def __init__(self):
        self.spring = np.zeros(3)
        self.stiffness = 0.0
        self.normal = 0.0
        self.tangential = np.zeros(3)
        self.stored = 0.0
        self.slip = 0.0


class Spheres:
    """Equal spheres and a plate, stepped by velocity Verlet with the default contact law.

    ``problem`` gives the constants (`abradem.dem.state.make_problem`).
    """

    def __init__(self, problem, positions, velocities, spins):
        self.problem = problem
        self.x = np.array(positions, float)
        self.v = np.array(velocities, float)
        self.w = np.array(spins, float)
        self.half_w = self.w.copy()
        count = len(self.x)
        weight = np.array([0.0, -problem.mass * problem.gravity, 0.0])
        self.force = np.tile(weight, (count, 1))
        self.torque = np.zeros((count, 3))
        self.rolling = np.zeros(count)
        self.contacts = {}
        self.worn = np.zeros(3)

    def step(self):
        p = self.problem
        kick = 0.5 * p.dt / p.mass
        half_v = self.v + kick * self.force
        next_v = half_v + kick * self.force
        half_w = self.half_w
        next_w = half_w + (half_w - self.w)
        self.x += p.dt * half_v
        self.force[:] = [0.0, -p.mass * p.gravity, 0.0]
        self.torque[:] = 0.0
        self.rolling[:] = 0.0
        for i in range(len(self.x)):
            self._plate(i, half_v, next_v, half_w, next_w)
        for i, j in itertools.combinations(range(len(self.x)), 2):
            self._pair(i, j, half_v, next_v, half_w, next_w)
        self.v = half_v + kick * self.force
        self.half_w = self._turned(half_w)
        self.w = 0.5 * (half_w + self.half_w)

    def _turned(self, spins):
        p = self.problem
        turn = p.dt / p.inertia
        spins = spins + turn * self.torque
        size = np.linalg.norm(spins, axis=1)
        left = np.maximum(size - turn * self.rolling, 0.0)
        return spins * np.divide(left, size, out=np.zeros_like(size), where=size > 0)[:, None]

    def _plate(self, i, half_v, next_v, half_w, next_w):
        p, plate = self.problem, self.problem.plate
        along_axis = np.array([plate.cos, plate.sin, 0.0])
        across_axis = np.array([0.0, 0.0, 1.0])
        along = np.clip(self.x[i] @ along_axis, -plate.half_length, plate.half_length)
        across = np.clip(self.x[i, 2], -plate.half_width, plate.half_width)
        away = self.x[i] - along * along_axis - across * across_axis
        distance = np.linalg.norm(away)
        overlap = p.radius - distance
        key = ("plate", i)
        if overlap <= 0.0 and key not in self.contacts:
            return
        old = self.contacts.get(key, Contact())
        n = away / distance
        slide = across_part(half_v[i] - p.radius * np.cross(half_w[i], n), n)
        new = Contact()
        if overlap > 0.0:
            new = self._law(
                p.plate_law, old, overlap, n, p.radius, half_v[i], next_v[i], half_w[i], next_w[i]
            )
            self._apply(i, new, n, p.radius)
            self.rolling[i] += p.plate_law.rolling_friction * new.normal * p.radius
            self.contacts[key] = new
        else:
            del self.contacts[key]
        mu = p.plate_law.static_friction
        distance = np.linalg.norm(slide) * p.dt
        work_old, work = -old.tangential @ slide * p.dt, -new.tangential @ slide * p.dt
        self.worn[0] += 0.5 * (old.normal + new.normal) * distance
        self.worn[1] += 0.5 * (
            old.slip * max(work_old, 0.0) + new.slip * max(work, 0.0)
        ) / mu  # fmt: skip
        self.worn[2] += (0.5 * (work_old + work) - (new.stored - old.stored)) / mu

    def _pair(self, i, j, half_v, next_v, half_w, next_w):
        p = self.problem
        away = self.x[i] - self.x[j]
        distance = np.linalg.norm(away)
        overlap = 2.0 * p.radius - distance
        key = (i, j)
        if overlap <= 0.0:
            self.contacts.pop(key, None)
            return
        n = away / distance
        arm = 0.5 * distance
        new = self._law(
            p.pair_law, self.contacts.get(key, Contact()), overlap, n, arm,
            half_v[i] - half_v[j], next_v[i] - next_v[j],
            half_w[i] + half_w[j], next_w[i] + next_w[j],
        )  # fmt: skip
        self._apply(i, new, n, arm)
        new_n, new_t = new.normal, new.tangential
        self.force[j] -= new_n * n + new_t
        self.torque[j] += np.cross(arm * n, -new_t)
        self.rolling[[i, j]] += p.pair_law.rolling_friction * new_n * p.radius
        self.contacts[key] = new

    def _apply(self, i, contact, n, arm):
        self.force[i] += contact.normal * n + contact.tangential
        self.torque[i] += np.cross(-arm * n, contact.tangential)

    def _law(self, law, old, overlap, n, arm, half_v, next_v, half_w, next_w):
        dt = self.problem.dt
        half = half_v - arm * np.cross(half_w, n)
        full = next_v - arm * np.cross(next_w, n)
        new = Contact()
        new.stiffness = law.kt * math.sqrt(overlap)
        new.normal = max(law.kn * overlap**1.5 - law.cn * overlap**0.25 * (full @ n), 0.0)
        du = across_part(half, n) * dt
        if old.stiffness == 0.0:
            approach = -(half @ n) * dt
            du *= min(1.0, overlap / approach) if approach > 0 else 1.0
            spring = -2.0 / 3.0 * new.stiffness * du
        else:
            turned = across_part(old.spring, n)
            size = np.linalg.norm(turned)
            if size > 0.0:
                turned *= np.linalg.norm(old.spring) / size
            turned *= min(1.0, new.stiffness / old.stiffness)
            spring = turned - 0.5 * (old.stiffness + new.stiffness) * du
        cap = law.static_friction * new.normal
        damping = -law.ct * overlap**0.25 * across_part(full, n)
        trial = spring + damping
        size = np.linalg.norm(trial)
        new.tangential = trial * (cap / size) if size > cap else trial
        stretch = np.linalg.norm(spring)
        new.spring = spring * (cap / stretch) if stretch > cap else spring
        if size > cap:
            new.slip = 1.0 - damper_share(new.spring, damping, cap)
        new.stored = new.spring @ new.spring / (2.0 * new.stiffness)
        return new


def damper_share(spring, damping, cap):
    """Largest w in [0, 1] with |spring + w damping| <= cap, for |spring| <= cap: bisection.

    The length is a convex function of w, so there is one such w.
    """
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if np.linalg.norm(spring + middle * damping) <= cap * (1.0 + 1e-14):
            low = middle
        else:
            high = middle
    return low


def across_part(v, n):
    """Part of v normal to n."""
    return v - (v @ n) * n


def fused(a, b, c):
    """a b + c, rounded once: a fraction becomes the float that is nearest to it."""
    return float(Fraction(a) * Fraction(b) + Fraction(c))
