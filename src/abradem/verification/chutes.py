"""A chute of a plate, an arc and a plate: this engine beside other codes with the same options.

All codes get the same triangles and the same particles, as the jet of `codes`. Their tables were
computed with `benchmarks/compare_codes.py`.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.dem.surface import CELL_SUMS, Surface
from abradem.verification.checks import Check
from abradem.verification.codes import constants_of, halton, scene_of
from abradem.verification.experiments import with_law
from abradem.verification.scenes import Film, Scene
from abradem.verification.surface_scenes import extruded

PARTICLES, RATE, END, STEP = 60, 200.0, 0.8, 2e-6
PATCH, HEIGHT, SPEED = 0.08, 0.35, 3.0
"""Edge of the factory patch and height of the patch, m; speed of the release, m/s."""

STEEP, FLAT = 45.0, 10.0
"""Slopes of the upper and the lower plate, degrees."""

UPPER_END = np.array([-0.2, 0.2])
"""Upper end of the chute (x, y), m."""

ARC_RADIUS, ARC_FACETS = 0.2, 7
PLATE_LENGTH, PLATE_FACETS, WIDTH = 0.15, 3, 0.3
GRAVITY = 9.81

LARGEST_DIFFERENCE = 0.02
"""Largest difference of the impulse from other codes, as a share."""

LEAST_CORRELATION = 0.97
"""Least correlation of the profile along the chute with that of another code."""

_NUDGES = 1e-7 * np.arange(1, 9)


def chute_profile() -> np.ndarray:
    """Return the corners (x, y) of the chute from its upper end on, m, shape (segments + 1, 2)."""
    turn = (STEEP - FLAT) / ARC_FACETS
    facet = 2.0 * ARC_RADIUS * np.sin(np.radians(0.5 * turn))
    bent = STEEP - (np.arange(ARC_FACETS) + 0.5) * turn
    slopes = np.radians(np.concatenate([[STEEP] * PLATE_FACETS, bent, [FLAT] * PLATE_FACETS]))
    plate = [PLATE_LENGTH / PLATE_FACETS] * PLATE_FACETS
    lengths = np.concatenate([plate, [facet] * ARC_FACETS, plate])
    steps = np.stack([lengths * np.cos(slopes), -lengths * np.sin(slopes)], axis=1)
    return UPPER_END + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def chute() -> Surface:
    """Return the chute as a surface: two triangles for each segment of its profile."""
    return extruded(chute_profile(), WIDTH)


def releases() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times (s), positions (m) and velocities (m/s) of the particles.

    The positions are a Halton sequence.
    """
    times = np.round(np.arange(PARTICLES) / RATE / STEP) * STEP
    places = [
        (PATCH * (halton(i + 1, 2) - 0.5) - 0.15, HEIGHT, PATCH * (halton(i + 1, 3) - 0.5))
        for i in range(PARTICLES)
    ]
    return times, np.array(places), np.tile([0.0, -SPEED, 0.0], (PARTICLES, 1))


def impulse(velocities: np.ndarray) -> tuple[float, float]:
    """Return the impulse of the particles on the chute along x and down, N s.

    Parameters
    ----------
    velocities : ndarray, shape (particles, 3)
        Velocities at `END`, m/s, when all particles are in flight. The momentum at the end, minus
        that of the release and of gravity, is the impulse of the chute.
    """
    times, _, before = releases()
    given = velocities.sum(axis=0) - before.sum(axis=0)
    given[1] += GRAVITY * (END - times).sum()
    return float(-Scene().mass * given[0]), float(Scene().mass * given[1])


def nearest_segment(x, y) -> tuple[np.ndarray, np.ndarray]:
    """Return the segment of the profile that is nearest to each point, and its distance, m."""
    corners = chute_profile()
    begin, along = corners[:-1], np.diff(corners, axis=0)
    arm = np.stack([x, y], axis=-1)[..., None, :] - begin
    share = np.clip((arm * along).sum(axis=-1) / (along**2).sum(axis=-1), 0.0, 1.0)
    away = arm - share[..., None] * along
    distance = np.sqrt((away**2).sum(axis=-1))
    return distance.argmin(axis=-1), distance.min(axis=-1)


def normals() -> np.ndarray:
    """Return the unit normals of the segments, upwards, shape (segments, 2)."""
    along = np.diff(chute_profile(), axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.stack([-along[:, 1], along[:, 0]], axis=1)


def our_chute(code: str, variant: str, nudge: float = 0.0) -> dict[str, np.ndarray]:
    """Return impulse (2,), and normal impulse and sliding wear by segment, of this engine.

    ``nudge`` (m) shifts all particles along x: see `codes.our_jet`.
    """
    from abradem.dem.state import DONE, make_problem, make_state
    from abradem.dem.synchronous import advance

    surface = chute()
    scene = scene_of(variant)
    setup = scene.setup(surface=surface, time_step=STEP, duration=END, removal_depth=20.0)
    times, places, velocities = releases()
    problem, schedule = make_problem(
        scene.case(), setup, (times, places + np.array([nudge, 0.0, 0.0]), velocities)
    )
    damping = constants_of(code, 0.5)["ct"] / constants_of(code, 1.0)["ct"]
    problem = with_law(problem, pairs=True, ct=damping)
    state = make_state(problem, PARTICLES, surface)
    if advance(problem, schedule, state, round(END / STEP)) != DONE:
        raise RuntimeError("chute ended early")
    film = Film(STEP)
    film.record(END, problem, state)
    ended = np.column_stack([film.frames[-1][name] for name in ("vx", "vy", "vz")])
    assert state.mesh is not None
    pushed = state.mesh.sums[:, CELL_SUMS.index("normal_impulse")]
    return {
        "impulse": np.array(impulse(ended)),
        "normal_impulse": pushed.reshape(-1, 2).sum(axis=1),
        "sliding": state.facet_wear[1, :, 0].reshape(-1, 2).sum(axis=1),
    }


def compare_chutes(reference: pd.DataFrame) -> pd.DataFrame:
    """Compare the chute of other codes with this engine.

    Parameters
    ----------
    reference : pandas.DataFrame
        code, variant, quantity (``impulse`` along x and down, or a profile by segment),
        ``segment`` and value.

    Returns
    -------
    pandas.DataFrame
        The columns of ``reference``, with ``ours``, ``reference`` in place of value, and ``spread``
        between nudged particles of this engine.
    """
    parts = []
    for (code, variant), rows in reference.groupby(["code", "variant"], sort=False):
        ours = our_chute(code, variant)
        nudged = [our_chute(code, variant, nudge) for nudge in _NUDGES]
        for quantity, part in rows.groupby("quantity", sort=False):
            at = part["segment"].to_numpy()
            spread = np.std([one[str(quantity)] for one in nudged], axis=0, ddof=1)
            parts.append(
                part.rename(columns={"value": "reference"}).assign(
                    ours=ours[str(quantity)][at], spread=spread[at]
                )
            )
    return pd.concat(parts, ignore_index=True)


def chute_checks(compared: pd.DataFrame) -> list[Check]:
    """Return checks of impulse and profile of the chute, see `compare_chutes`."""
    found = []
    for (code, variant, quantity), part in compared.groupby(
        ["code", "variant", "quantity"], sort=False
    ):
        words = f"{code} ({variant}), chute"
        if quantity != "impulse":
            match = float(np.corrcoef(part["ours"], part["reference"])[0, 1])
            found.append(
                Check(f"{words}: correlation of the profile of {quantity.replace('_', ' ')}",
                      match, LEAST_CORRELATION, kind="at least")
            )  # fmt: skip
            continue
        size = float(np.hypot(*part["reference"]))
        for row, way in zip(part.itertuples(), ("along x", "down"), strict=True):
            allowed = LARGEST_DIFFERENCE * size + 2.0 * row.spread
            found.append(
                Check(f"{words}: impulse {way}", row.ours, row.reference, allowed, "N s",
                      "absolute",
                      "chute: 2 % and twice the spread between particles nudged by 0.1 um")
            )  # fmt: skip
    return found
