"""Parts 9 and 10: independence of the facet size; mass, energy and slope of a bed at rest."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from abradem.dem.model import Interaction, SimulationResult
from abradem.verification.checks import Check, checks_table
from abradem.verification.jets import JET, jet_case, run_jet
from abradem.verification.scenes import Film, Scene, solid

FACETS, BED = 9, 10
_SIZES = (0.3, 0.1, 0.05, 0.02, 0.01, 0.005)

HEAP = Scene(
    particle=solid(0.5e9, 0.25, 2500.0),
    plate=solid(50e9, 0.3, 7800.0),
    radius=0.008,
    interaction=Interaction(0.3, 0.5, 0.1),
)
"""Particles with high friction on a level plate; they are soft only to allow a long time step."""

REPOSE = (15.0, 40.0)
"""Range of the angle of repose of rough spheres, degrees (Beakawi Al-Hashemi & Baghabra Al-Amoudi
2018, Powder Technol. 330:397)."""

POURED = 0.5
"""Downward speed of the poured particles, m/s."""

AT_REST = 1e-3 * POURED
ROUNDING = 1e-10
_LAYER_TIME = 0.065
_LAYERS = 60


def facet_checks() -> tuple[list[Check], pd.DataFrame]:
    """Return checks of the worn volume and the maps of one jet for several facet sizes."""
    rows, maps = [], {}
    for size in _SIZES:
        setup = JET.setup(facet_size=size, duration=3.0, sample_interval=0.5)
        result = run_jet(jet_case(seed=3), setup)
        maps[size] = result.facet_wear_all
        rows.append(
            {"facets": result.facet_wear_all.shape[1], "work": result.worn[-1, 0],
             "value": result.facet_wear_all[0].sum()}
        )  # fmt: skip
    table = pd.DataFrame(rows)
    checks = [
        Check("total worn volume over facet sizes: largest difference",
              table["work"].max() - table["work"].min(), 0.0, 0.0, "J", "absolute"),
        Check("sum over facets is the worn volume: largest difference",
              (table["value"] / table["work"] - 1.0).abs().max(), 0.0, 1e-12, kind="absolute"),
    ]  # fmt: skip
    fine = maps[0.01]
    for size, ratio in ((0.02, 2), (0.05, 5), (0.1, 10)):
        n = fine.shape[1] // ratio
        summed = fine.reshape(3, n, ratio, n, ratio).sum(axis=(2, 4))
        worst = np.abs(summed - maps[size]).max() / maps[size].max()
        checks.append(
            Check(f"facets of {1e3 * size:g} mm are sums of 10 mm ones: largest difference",
                  worst, 0.0, 1e-12, kind="absolute")
        )  # fmt: skip
    return checks, table


class _BalanceFilm(Film):
    """Film that also records the balances of mass and energy."""

    def __init__(self, interval: float):
        super().__init__(interval)
        self.counts: list[tuple[int, int, int]] = []
        self.dissipated: list[float] = []

    def record(self, time, problem, state):
        from abradem.dem.energy import energy_balance

        super().record(time, problem, state)
        if self.frames:
            present = self.frames[-1]["x"].size
            tally = state.tally[0]
            self.counts.append((int(tally["placed"]), int(tally["removed"]), present))
            self.dissipated.append(energy_balance(problem, state)["dissipated"])


def pour() -> tuple[SimulationResult, _BalanceFilm]:
    """Pour layers of nine particles on a level plate, followed by a time without feed."""
    pitch = 2.2 * HEAP.radius
    square = [(i * pitch, j * pitch) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    times, places = [], []
    rng = np.random.default_rng(7)
    for layer in range(_LAYERS):
        turn, shift = rng.uniform(0.0, math.pi), rng.uniform(-pitch, pitch, 2)
        for a, b in square:
            times.append(layer * _LAYER_TIME)
            places.append(
                (math.cos(turn) * a - math.sin(turn) * b + shift[0], 0.22,
                 math.sin(turn) * a + math.cos(turn) * b + shift[1])
            )  # fmt: skip
    duration = _LAYERS * _LAYER_TIME + 1.5
    film = _BalanceFilm(0.02)
    result = run_jet(
        HEAP.case(),
        HEAP.setup(duration=duration, sample_interval=0.1),
        releases=(times, places, np.tile([0.0, -POURED, 0.0], (len(times), 1))),
        recorder=film,
    )
    return result, film


def profile(film: _BalanceFilm) -> pd.DataFrame:
    """Return the positions of the resting particles: distance from the axis and height, m."""
    last = film.frames[-1]
    return pd.DataFrame({"x": np.hypot(last["x"], last["z"]), "height": last["y"]})


def repose_angle_deg(particles: pd.DataFrame, radius: float) -> float:
    """Return the slope of the heap from the highest particles in rings one diameter wide, deg."""
    ring = (particles["x"] / (2.0 * radius)).astype(int)
    top = particles.loc[particles.groupby(ring)["height"].idxmax()]
    top = top[top["height"] > 1.5 * radius]
    return math.degrees(math.atan(-np.polyfit(top["x"], top["height"], 1)[0]))


def bed_checks() -> tuple[list[Check], pd.DataFrame]:
    """Return checks of the mass, the energy and the slope of the heap."""
    result, film = pour()
    counts = np.array(film.counts)
    dissipated = np.array(film.dissipated)
    particles = profile(film)
    angle = repose_angle_deg(particles, HEAP.radius)
    speed = max(float(np.abs(film.frames[-1][v]).max()) for v in ("vx", "vy", "vz"))
    gained = max(0.0, -float(np.diff(dissipated).min())) / result.energy["inserted"]
    checks = [
        Check("released = removed + resident at every look",
              float(np.abs(counts[:, 0] - counts[:, 1] - counts[:, 2]).max()), 0.0, 0.0,
              kind="absolute"),
        Check("energy gained between two looks, share of that put in", gained, ROUNDING,
              kind="at most", note="rounding of some million sums"),
        Check("largest speed in the heap at rest", speed, AT_REST, unit="m/s", kind="at most",
              note="at rest: a thousandth of the speed at which the particles were poured"),
        Check("angle of repose", angle, 0.5 * sum(REPOSE), 0.5 * (REPOSE[1] - REPOSE[0]), "deg",
              "absolute", note="plausible for rough spheres; a heap of a few particles' height"),
        Check("particles resting on the plate", float(counts[-1, 2]), 100.0, kind="at least"),
    ]  # fmt: skip
    return checks, particles


def study() -> dict[str, pd.DataFrame]:
    """Return the tables of these parts."""
    facets, sizes = facet_checks()
    bed, particles = bed_checks()
    return {
        "checks": pd.concat(
            [checks_table(FACETS, facets), checks_table(BED, bed)], ignore_index=True
        ),
        "sizes": sizes,
        "heap": particles,
    }
