"""The contact law: Hertz-Mindlin with viscous damping, Coulomb friction and rolling resistance.

Symbols: d overlap, n unit normal (towards the particle the force acts on), v_n speed of
separation, S = sqrt(d), Q = d^{1/4}. The normal force, the tangential stiffness and the
tangential damping are

    F_n = kn d S - cn Q v_n,    k_t = kt S,    c_t = ct Q,
    F_t = -k_t s - c_t v_t,     |F_t| <= mu |F_n|,

with the accumulated tangential displacement s, or (incremental) with the spring force of the
previous step instead of -k_t s, reduced with the stiffness when unloading. The variants of the
damping and of its cap are in `tangential_force`. Sources: Hertz (1882, J. Reine Angew. Math.
92:156) for the elastic normal force; Mindlin & Deresiewicz (1953, J. Appl. Mech. 20:327) for the
tangential stiffness; Tsuji, Tanaka & Ishida (1992, Powder Technol. 71:239) for the damping.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abradem.dem.cache import kernel
from abradem.dem.damping import exact_beta, nominal_beta
from abradem.dem.model import ContactModel, Interaction, Material
from abradem.dem.vectors import dot, fma, plus, scaled
from abradem.elastic import effective_shear_modulus, effective_youngs_modulus, hertz_stiffness

DAMPING_CAPPED, DAMPING_NONE, DAMPING_UNCAPPED = 0, 1, 2
_DAMPING_CODES = {
    "capped": DAMPING_CAPPED,
    "none": DAMPING_NONE,
    "uncapped": DAMPING_UNCAPPED,
}


_FLAT = 1e-24
"""Square of the angle, rad2, below which the tangent plane is taken as not rotated."""


class Law(NamedTuple):
    """Constants of one kind of contact (particle-plate or particle-particle), SI."""

    kn: float
    cn: float
    kt: float
    ct: float
    static_friction: float
    rolling_friction: float
    clipped: bool
    incremental: bool
    tangential_damping: int


def effective_moduli(a: Material, b: Material) -> tuple[float, float]:
    """Return E* and G* of two materials, Pa, see `abradem.elastic`."""
    return (
        effective_youngs_modulus(
            a.youngs_modulus, a.poisson_ratio, b.youngs_modulus, b.poisson_ratio
        ),
        effective_shear_modulus(a.shear_modulus, a.poisson_ratio, b.shear_modulus, b.poisson_ratio),
    )


def make_law(
    a: Material,
    b: Material,
    interaction: Interaction,
    model: ContactModel,
    radius: float,
    mass: float,
) -> Law:
    """Return the constants of a contact.

    ``kn = 4/3 E* sqrt(R*)`` (Hertz 1882), ``kt = 8 G* sqrt(R*)`` (Mindlin & Deresiewicz 1953),
    ``c = 2 sqrt(5/6) beta sqrt(S m*)`` with the stiffness ``S_n = 2 E* sqrt(R* d)`` or
    ``S_t = 8 G* sqrt(R* d)`` (Tsuji, Tanaka & Ishida 1992).

    Parameters
    ----------
    a, b : Material
    interaction : Interaction
    model : ContactModel
    radius, mass : float
        Effective radius R* (m) and mass m* (kg) of the pair.

    Returns
    -------
    Law
    """
    e_star, g_star = effective_moduli(a, b)
    nominal = nominal_beta(interaction.restitution)
    beta = exact_beta(interaction.restitution) if model.normal == "exact_e" else nominal
    root = math.sqrt(radius)
    scale = 2.0 * math.sqrt(5.0 / 6.0)
    return Law(
        kn=float(hertz_stiffness(e_star, radius)),
        cn=scale * beta * math.sqrt(2.0 * e_star * root * mass),
        kt=8.0 * g_star * root,
        ct=scale * nominal * math.sqrt(8.0 * g_star * root * mass),
        static_friction=interaction.static_friction,
        rolling_friction=interaction.rolling_friction,
        clipped=model.normal != "nominal_attractive",
        incremental=model.tangential == "incremental",
        tangential_damping=_DAMPING_CODES[model.tangential_damping],
    )


@kernel(inline=True)
def normal_force(law, overlap, separation_speed):
    """Return (F_n, S, Q): total normal force (N), sqrt(d) and d^{1/4} of the overlap d."""
    s = math.sqrt(overlap)
    q = math.sqrt(s)
    force = fma(law.kn * overlap, s, -(law.cn * q * separation_speed))
    if law.clipped and force < 0.0:
        force = 0.0
    return force, s, q


@kernel(inline=True)
def entry_share(overlap, approach):
    """Return the fraction of the step with contact, for the step in which a contact begins.

    ``approach`` is the distance by which the surfaces approached in the step, m.
    """
    if approach > overlap:
        return overlap / approach
    return 1.0


@kernel(inline=True)
def rotated(spring, n):
    """Return the spring rotated into the plane normal to ``n``, with its length preserved."""
    length2, along = dot(spring, spring), dot(spring, n)
    # On a flat face the normal part of the spring is only rounding.
    if along * along <= _FLAT * length2:
        return spring
    left = plus(spring, -along, n)
    left2 = dot(left, left)
    if left2 == 0.0:
        return 0.0, 0.0, 0.0
    return scaled(left, math.sqrt(length2 / left2))


@kernel(inline=True)
def slip_share(spring, damping, room):
    """Return the share of the tangential velocity with which a slipping contact slips.

    Spring f and damper act side by side, in series with the friction mu F_n. While the contact
    slips, f and the part w of the velocity that the damper takes hold the limit,
    |f - c_t w v_t| = mu F_n; the share 1 - w is slip. It grows from 0 where the trial force
    reaches the limit to 1 where the spring alone does, so it needs no flag. In the plane of an
    impact the slip velocity is v_t - (mu F_n - f)/c_t.

    Parameters
    ----------
    spring : tuple of float
        Spring force f, limited to mu F_n, N.
    damping : tuple of float
        Damping force -c_t v_t of the trial force, N.
    room : float
        (mu F_n)^2 - f^2, N2.
    """
    along, damping2 = dot(spring, damping), dot(damping, damping)
    if damping2 == 0.0:
        return 1.0
    # The positive root of w^2 D^2 + 2 w f.D = room, without the difference of two close numbers.
    root = math.sqrt(fma(damping2, room, along * along))
    taken = room / (along + root) if along > 0.0 else (root - along) / damping2
    return max(1.0 - taken, 0.0)


@kernel(inline=True)
def tangential_force(law, fn, s, q, spring, k_before, du, vt):
    """Return the tangential force, new spring, its stiffness, stored energy and share of slip.

    Parameters
    ----------
    law : Law
    fn, s, q : float
        From `normal_force`.
    spring : tuple of float
        Spring force, N (incremental), or accumulated displacement, m, of the previous step,
        rotated into the current tangent plane.
    k_before : float
        Tangential stiffness of the previous step, N/m; 0 in the first step of a contact.
    du : tuple of float
        Tangential displacement in contact during the step, m.
    vt : tuple of float
        Predicted tangential velocity at the contact point, m/s.
    """
    k = law.kt * s
    if law.incremental:
        if k_before == 0.0:
            # The overlap grows linearly from zero, so the mean of its root is 2/3 of the last.
            factor, mean = 1.0, 2.0 / 3.0 * k
        else:
            factor, mean = min(k / k_before, 1.0), 0.5 * (k_before + k)
        stretched = plus(scaled(spring, factor), -mean, du)
    else:
        stretched = scaled(plus(spring, 1.0, du), -k)

    cap = law.static_friction * abs(fn)
    cap2 = cap * cap
    stretched2 = dot(stretched, stretched)
    slips = False
    damping = (0.0, 0.0, 0.0)
    if law.tangential_damping == DAMPING_CAPPED:
        damping = scaled(vt, -(law.ct * q))
        force = plus(stretched, -(law.ct * q), vt)
        trial2 = dot(force, force)
        if trial2 > cap2:
            slips = True
            force = scaled(force, cap / math.sqrt(trial2))
    else:
        force = stretched
        if stretched2 > cap2:
            slips = True
            force = scaled(force, cap / math.sqrt(stretched2))
        elif law.tangential_damping == DAMPING_UNCAPPED:
            force = plus(stretched, -(law.ct * q), vt)
    # The spring force itself never exceeds the cap. Setting it to the cap minus the damping
    # force would add energy.
    if stretched2 > cap2:
        stretched = scaled(stretched, cap / math.sqrt(stretched2))
        stretched2 = cap2
    slip = slip_share(stretched, damping, cap2 - stretched2) if slips else 0.0
    energy = 0.5 * stretched2 / k
    if law.incremental:
        spring = stretched
    else:
        spring = (-stretched[0] / k, -stretched[1] / k, -stretched[2] / k)
    return force, spring, k, energy, slip


@kernel(inline=True)
def slowed(spin, loss):
    """Return the spin with its magnitude reduced by ``loss`` (rad/s), but never reversed."""
    magnitude = math.sqrt(dot(spin, spin))
    if magnitude <= loss:
        return 0.0, 0.0, 0.0
    return scaled(spin, 1.0 - loss / magnitude)
