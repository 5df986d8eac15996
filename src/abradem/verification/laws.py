"""Part 1: all closed forms with a converged time step, parameter sweeps, order of convergence."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pandas as pd

from abradem.dem.damping import exact_beta, nominal_beta
from abradem.dem.model import ContactModel
from abradem.verification import closed_forms as exact
from abradem.verification.checks import Check, checks_table
from abradem.verification.experiments import (
    STEPS_PER_CONTACT,
    head_on,
    hertz_pair,
    incline,
    simulated_slide_to_roll,
)
from abradem.verification.scenes import NOMINAL_SPEED, Scene, filmed, solid

PART = 1
SPEED = NOMINAL_SPEED

BETA_ANCHORS = {
    0.20: (0.7313, 0.325), 0.35: (0.4186, 0.434), 0.50: (0.2553, 0.550),
    0.65: (0.1499, 0.675), 0.80: (0.0744, 0.808), 0.95: (0.0165, 0.9505),
}  # fmt: skip
"""By restitution: the damping for which the rebound equals it, and the rebound with clipped
textbook damping. Both are from an integration of the scaled impact that is independent of this
package."""

SPHERE_PAIRS = {
    "glass": (solid(48e9, 0.20, 2800.0), exact.Hertz(10697.0, 274.1e-6, 40.34e-6)),
    "limestone": (solid(20e9, 0.25, 2500.0), exact.Hertz(7108.0, 368.3e-6, 54.20e-6)),
}
"""Two spheres of R 10 mm that collide at +-10 m/s (Chung & Ooi 2011, test 1)."""

SPHERES_ON_PLANE = {
    "aluminium alloy": (solid(70e9, 0.30, 2699.0), exact.Hertz(11370.0, 49.72e-6, 731.7e-6)),
    "magnesium alloy": (solid(40e9, 0.35, 1800.0), exact.Hertz(7233.0, 52.12e-6, 767.1e-6)),
}
"""A sphere of R 100 mm on a rigid plane at 0.2 m/s (Chung & Ooi 2011, test 2)."""

RIGID = solid(1e24, 0.30, 7800.0)

SOFT = Scene(particle=solid(1e7, 0.25, 2500.0)).with_interaction(
    restitution=0.3, static_friction=0.3
)
"""A soft sphere: its normal vibration decays while it slides and rolls."""

GRAVITY = 9.81

ONE_STEP = 1.0 / STEPS_PER_CONTACT
"""Tolerance if the start and end of a contact, or of slip, are resolved to a step; the actual
errors are smaller."""

ROUNDING = 1e-9
"""Tolerance if the discrete motion satisfies the closed form exactly."""

CREEP = 1e-6 * GRAVITY
"""Tolerance of an acceleration at rest, m/s2: the normal vibration has decayed to a millionth."""


def rebound_checks() -> list[Check]:
    """Return checks of the rebound of normal impacts and of the damping."""
    checks = []
    for e, (beta, clipped) in BETA_ANCHORS.items():
        scene = Scene().with_interaction(restitution=e)
        rebound = scene.impact(SPEED, 0.0).normal_velocity / SPEED
        checks.append(Check(f"damping beta, e = {e:g}", exact_beta(e), beta, 6e-5, kind="absolute"))
        checks.append(Check(f"rebound of a normal impact, e = {e:g}", rebound, e, ONE_STEP))
        textbook = replace(scene, contact=ContactModel(normal="nominal_clipped"))
        rebound = textbook.impact(SPEED, 0.0).normal_velocity / SPEED
        checks.append(
            Check(f"rebound, textbook beta clipped, e = {e:g}", rebound, clipped, 6e-4,
                  kind="absolute")
        )  # fmt: skip
    return checks


def hertz_checks() -> list[Check]:
    """Return checks of force, overlap and duration of elastic impacts against published values."""
    checks = []
    for name, (material, known) in SPHERE_PAIRS.items():
        scene = Scene(material).with_interaction(restitution=1.0)
        found = hertz_pair(scene, 10.0, known.duration)
        checks += _hertz(f"two {name} spheres", found, known)
    for name, (material, known) in SPHERES_ON_PLANE.items():
        scene = Scene(material, RIGID, radius=0.1).with_interaction(restitution=1.0)
        impact = scene.impact(0.2, 0.0)
        found = exact.Hertz(impact.max_normal_force, impact.max_overlap, impact.contact_time)
        checks += _hertz(f"{name} sphere on a rigid plane", found, known)
    return checks


def _hertz(words: str, found: exact.Hertz, known: exact.Hertz) -> list[Check]:
    units = {"force": "N", "overlap": "m", "duration": "s"}
    return [
        Check(f"Hertz {name}, {words}", getattr(found, name), getattr(known, name), ONE_STEP, unit)
        for name, unit in units.items()
    ]


def slip_checks() -> list[Check]:
    """Return checks of impacts that slip throughout: e = 1, and e < 1 with capped damping."""
    checks = []
    for mu, mu_r, e in ((0.3, 0.0, 1.0), (0.45, 0.0, 1.0), (0.3, 0.05, 1.0), (0.3, 0.0, 0.5)):
        scene = Scene().with_interaction(restitution=e, static_friction=mu, rolling_friction=mu_r)
        angle = exact.slip_angle_deg(mu, e, mu_r) + 5.0
        v_n, v_t = _components(angle)
        form = exact.gross_slip(scene.mass, scene.radius, v_n, v_t, mu, e, mu_r)
        impact = scene.impact(SPEED, angle)
        words = f"gross slip, mu = {mu:g}, mu_r = {mu_r:g}, e = {e:g}"
        checks += [
            Check(f"{words}: v_t'", impact.tangential_velocity, form.tangential_velocity, ONE_STEP,
                  "m/s"),
            Check(f"{words}: spin", -impact.spin[2], form.spin, ONE_STEP, "rad/s"),
            Check(f"{words}: total", impact.total, form.total, ONE_STEP, "J"),
        ]  # fmt: skip
    return checks


def balance_checks() -> list[Check]:
    """Return checks of the friction work, for any tangential law, and of momentum conservation."""
    checks = []
    for tangential in ("incremental", "displacement"):
        scene = Scene(contact=ContactModel(tangential=tangential))
        for angle in (10.0, 40.0, 75.0):
            impact = scene.impact(SPEED, angle)
            after = impact.tangential_velocity + scene.radius * impact.spin[2]
            work = exact.friction_work(scene.mass, _components(angle)[1], after)
            checks.append(
                Check(f"friction work = (m/7)(v_c^2 - v_c'^2), {tangential}, {angle:g} deg",
                      impact.friction_work, work, ROUNDING, "J")
            )  # fmt: skip
    scene = Scene().with_interaction(restitution=0.6)
    film, _ = head_on(scene, 2.0, 1e-4, spins=((10, -50, 120), (30, 70, -20)), offset=0.006)
    place = np.array([[film.of(k, i) for k in "xyz"] for i in (0, 1)])
    speed = np.array([[film.of(f"v{k}", i) for k in "xyz"] for i in (0, 1)])
    turn = np.array([[film.of(f"w{k}", i) for k in "xyz"] for i in (0, 1)])
    angular = (np.cross(place, speed, axis=1) + 0.4 * scene.radius**2 * turn).sum(axis=0)
    size = np.linalg.norm(angular[:, 0])
    checks += [
        Check("pair: linear momentum made, of that of one", np.abs(speed.sum(axis=0)).max() / 2.0,
              0.0, 1e-12, kind="absolute"),
        Check("pair: angular momentum made", np.abs(angular[:, -1] - angular[:, 0]).max() / size,
              0.0, ROUNDING, kind="absolute"),
    ]  # fmt: skip
    film, _ = head_on(Scene(), 2.0, 1e-4, spins=((0, 0, 200), (0, 0, -200)))
    checks.append(
        Check("two equal spheres, opposite spins: change of spin",
              float(np.abs(film.of("wz", 0) - 200.0).max()), 0.0, 0.0, "rad/s", "absolute")
    )  # fmt: skip
    return checks


def similarity_checks() -> list[Check]:
    """Return checks that wear over m v^2 is independent of speed, size, density and all moduli."""
    changes = {
        "speed": (Scene(), 8.0),
        "radius": (Scene(radius=0.04), SPEED),
        "density": (Scene(solid(15e9, 0.25, 4000.0)), SPEED),
        "all moduli": (Scene(solid(105e9, 0.25, 2500.0), solid(1400e9, 0.3, 7800.0)), SPEED),
    }
    base = Scene().impact(SPEED, 40.0).total / (Scene().mass * SPEED**2)
    checks = []
    for name, (scene, speed) in changes.items():
        ours = scene.impact(speed, 40.0).total / (scene.mass * speed**2)
        checks.append(Check(f"similarity: total/(m v^2), another {name}", ours, base, ROUNDING))
    return checks


def plane_checks() -> list[Check]:
    """Return checks of the transition from sliding to rolling, and of the incline."""
    form = exact.slide_to_roll(SOFT.mass, 1.0, 0.3, GRAVITY)
    found = simulated_slide_to_roll(SOFT, 1.0)
    checks = [
        Check(
            "slide to roll: final velocity 5/7 u0", found.velocity, form.velocity, ROUNDING, "m/s"
        ),
        Check("slide to roll: slipping ends after", found.time, form.time, ONE_STEP, "s"),
        Check("slide to roll: total = m u0^2/(7 mu)", found.total, form.total, ONE_STEP, "J"),
    ]
    for angle, mu_r, words in (
        (20.0, 0.0, "rolls"), (20.0, 0.05, "rolls"), (60.0, 0.0, "slides"), (60.0, 0.05, "slides"),
    ):  # fmt: skip
        exactly = exact.incline_acceleration(angle, 0.3, mu_r, GRAVITY)
        ours = incline(SOFT.with_interaction(rolling_friction=mu_r), angle)
        checks.append(
            Check(
                f"incline {angle:g} deg, mu_r = {mu_r:g}: {words}", ours, exactly, ROUNDING, "m/s2"
            )
        )
    rests = abs(incline(SOFT.with_interaction(rolling_friction=0.1), 5.0))
    checks.append(Check("incline 5 deg, mu_r = 0.1: rests", rests, 0.0, CREEP, "m/s2", "absolute"))
    return checks


def flight_check() -> Check:
    """Return the check of free flight against x0 + v t - g t^2 / 2."""
    scene, time = Scene(), 0.5
    velocity = np.array([3.0, 2.0, -1.0])
    start = np.array([0.0, 5.0, 0.0])
    setup = scene.setup(duration=time, sample_interval=time, removal_depth=50.0)
    _, film = filmed(scene.case(), setup, ([0.0], [start], [velocity]), every=0.1)
    last = film.time[-1]
    known = start + velocity * last - np.array([0.0, 0.5 * GRAVITY * last**2, 0.0])
    found = np.array([film.of(axis)[-1] for axis in "xyz"])
    return Check("free flight: distance from the parabola", float(np.linalg.norm(found - known)),
                 0.0, ROUNDING, "m", "absolute")  # fmt: skip


def law_checks() -> list[Check]:
    """Return checks of ``total`` at 30 degrees, e = 0.5, mu = 0.45, which differs between laws."""
    known = {
        "default": (ContactModel(), 0.187),
        "no tangential damping": (ContactModel(tangential_damping="none"), 0.384),
        "displacement, undamped": (
            ContactModel(tangential="displacement", tangential_damping="none"), 0.479,
        ),
    }  # fmt: skip
    return [
        Check(f"total/(m v^2) at 30 deg, {name}",
              Scene(contact=model).impact(SPEED, 30.0).total / (Scene().mass * SPEED**2),
              share, 6e-4, kind="absolute")
        for name, (model, share) in known.items()
    ]  # fmt: skip


def fast_checks() -> list[Check]:
    """Return all checks of this part except for the order of convergence."""
    return [
        *rebound_checks(), *hertz_checks(), *slip_checks(), *balance_checks(), *similarity_checks(),
        *plane_checks(), flight_check(), *law_checks(),
    ]  # fmt: skip


def restitution_sweep() -> pd.DataFrame:
    """Return damping and rebound over e for the three normal laws."""
    rows = []
    for e in np.round(np.arange(0.05, 1.0001, 0.05), 2):
        row = {"restitution": e, "exact_beta": exact_beta(e), "nominal_beta": nominal_beta(e)}
        for name, normal in (
            ("exact", "exact_e"), ("clipped", "nominal_clipped"),
            ("attractive", "nominal_attractive"),
        ):  # fmt: skip
            scene = Scene(contact=ContactModel(normal=normal)).with_interaction(restitution=e)
            row[f"rebound_{name}"] = scene.impact(SPEED, 0.0).normal_velocity / SPEED
        rows.append(row)
    return pd.DataFrame(rows)


def angle_sweep() -> pd.DataFrame:
    """Return elastic impacts over the angle, with exact values if the impact slips, else nan."""
    rows = []
    for mu in (0.1, 0.3, 0.45):
        scene = Scene().with_interaction(restitution=1.0, static_friction=mu)
        unit = scene.mass * SPEED**2
        for angle in np.arange(2.5, 88.0, 2.5):
            v_n, v_t = _components(angle)
            impact = scene.impact(SPEED, angle)
            slips = angle > exact.slip_angle_deg(mu, 1.0)
            form = exact.gross_slip(scene.mass, scene.radius, v_n, v_t, mu, 1.0)
            values = {
                "total": (impact.total / unit, form.total / unit),
                "tangential": (
                    impact.tangential_velocity / SPEED, form.tangential_velocity / SPEED,
                ),
                "spin": (
                    -impact.spin[2] * scene.radius / SPEED, form.spin * scene.radius / SPEED,
                ),
            }  # fmt: skip
            rows += [
                {"static_friction": mu, "angle": angle, "quantity": name, "ours": ours,
                 "exact": known if slips else math.nan}
                for name, (ours, known) in values.items()
            ]  # fmt: skip
    return pd.DataFrame(rows)


WEAR_MEASURES = {"total": "total", "sliding": "sliding", "friction": "friction_work"}
_STEPS = (8, 16, 32, 64, 128, 256)
_FINE = 32
"""Smallest number of steps per contact in the fit of the order of convergence."""
_REFERENCE_STEPS = 8192
_ANGLES = (20.0, 35.0, 50.0, 65.0)
_PHASES = 32


def convergence() -> pd.DataFrame:
    """Return the error of each wear measure over the steps per contact, averaged over the phase.

    Errors are shares of the mean of the wear measure over the angles, because ``sliding`` is almost
    zero at steep angles.
    """
    rows = []
    for e in (0.2, 0.5, 0.8):
        scene = Scene().with_interaction(restitution=e)
        best, coarse = {}, {}
        for angle in _ANGLES:
            base = scene.impact(SPEED, angle)
            duration = base.time_step * STEPS_PER_CONTACT
            best[angle] = scene.impact(SPEED, angle, time_step=duration / _REFERENCE_STEPS)
            for steps in _STEPS:
                coarse[angle, steps] = [
                    scene.impact(SPEED, angle, time_step=duration / steps, phase=phase)
                    for phase in (np.arange(_PHASES) + 0.5) / _PHASES
                ]
        for name, attribute in WEAR_MEASURES.items():
            scale = np.mean([getattr(one, attribute) for one in best.values()])
            for (angle, steps), impacts in coarse.items():
                mean = np.mean([getattr(one, attribute) for one in impacts])
                rows.append(
                    {"restitution": e, "angle": angle, "measure": name, "steps": steps,
                     "error": (mean - getattr(best[angle], attribute)) / scale}
                )  # fmt: skip
    return pd.DataFrame(rows)


def orders(convergence: pd.DataFrame) -> pd.DataFrame:
    """Return the slope of the mean absolute error over the step, in logarithms, for fine steps."""
    rows = []
    fine = convergence[convergence["steps"] >= _FINE]
    for measure, part in fine.groupby("measure", sort=False):
        mean = part.assign(error=part["error"].abs()).groupby("steps")["error"].mean()
        slope = -np.polyfit(np.log(mean.index), np.log(mean), 1)[0]
        rows.append({"measure": measure, "exponent": slope})
    return pd.DataFrame(rows)


def study() -> dict[str, pd.DataFrame]:
    """Return the tables of this part."""
    errors = convergence()
    order = orders(errors)
    checks = fast_checks()
    checks += [
        Check(f"order of convergence in the step, {row.measure}", row.exponent, 0.8,
              kind="at least", note="begin of contact and of slip are met to first order")
        for row in order.itertuples()
    ]  # fmt: skip
    return {
        "checks": checks_table(PART, checks),
        "restitution": restitution_sweep(),
        "angles": angle_sweep(),
        "convergence": errors,
    }


def _components(angle_deg: float) -> tuple[float, float]:
    angle = math.radians(angle_deg)
    return SPEED * math.cos(angle), SPEED * math.sin(angle)
