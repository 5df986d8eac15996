"""Part 7: the screw-conveyor check of the paper, a test of the order of magnitude only.

Materials and constants follow the paper (Yang et al. 2021). A depth rate of 1e-6 mm/s at
W = 1e-11 /Pa is F_n v_t = 100 W per square metre. The main check is a filled screw that turns:
flight, shaft and trough wear while as much leaves as is fed. The dimensions of the published
conveyor and its load are not known, so this is one of a usual size.

Two estimates without a screw are kept beside it: a filling that slides along the trough under its
own weight, q = p v, and a jet on an inclined plate.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pandas as pd

from abradem.dem.model import Interaction, Setup
from abradem.dem.surface import cell_areas
from abradem.elastic import sphere_volume
from abradem.geometry.build import prepared
from abradem.quantities import WEAR_MEASURES
from abradem.verification.checks import Check, checks_table
from abradem.verification.jets import rate_of, run_jet
from abradem.verification.scenes import Scene, solid

PART = 7
ARCHARD_CONSTANT = 1e-11
PUBLISHED = 1e-6
"""Published depth rate, mm/s, an order of magnitude."""

CONVEYOR = Scene(
    particle=solid(1e9, 0.3, 1500.0),
    plate=solid(210e9, 0.3, 7800.0),
    radius=0.008,
    interaction=Interaction(0.50, 0.46, 0.05),
)
"""Poisson ratios and rolling friction are not published; 0.3 and 0.05 are assumed."""

PARTICLES = Interaction(0.35, 0.56, 0.05)
_GRAVITY = 9.81
_MM = 1e3

SCREW: dict[str, Any] = {
    "kind": "screw", "length": 0.4, "radius": 0.075, "shaft_radius": 0.02, "pitch": 0.1,
    "clearance": 0.005, "rim": 0.1, "revolutions": 60.0,
}  # fmt: skip
"""Flight of 150 mm diameter in a trough of 400 mm; m, and rev/min."""

TURN = 60.0 / SCREW["revolutions"]
"""Time of a revolution, s."""

FEED = 0.45
"""kg/s; a screw of this size that is full conveys some 1.5 kg/s at a solid fraction of 0.6."""

FILLING_TURNS, TURNS = 4, 4
"""Revolutions until the screw is full, and those whose wear is taken."""

MEASURE = "total"

JUDGED_PARTS, JUDGED = ("flight", "trough"), "99th percentile"
"""What is compared with the published order. It is not known over which area that is a mean; the
most worn places are compared, and the notes of the checks hold the means.
"""

MOST_DRIFT = 0.1
"""Largest difference of feed and throughput, and of the filling in the two halves of the time, as a
share: what remains of a transient changes the wear by no more."""


def filling() -> pd.DataFrame:
    """Return the depth rates of sliding fillings for several heights and speeds, mm/s."""
    rows = []
    bulk_density = 0.6 * CONVEYOR.particle.density
    for height, speed in itertools.product((0.05, 0.1, 0.2), (0.05, 0.1, 0.3)):
        load = bulk_density * _GRAVITY * height * speed
        rows.append(
            {"scene": f"filling of {height:g} m at {speed:g} m/s",
             "depth_rate": load * ARCHARD_CONSTANT * _MM, "depth_stderr": 0.0}
        )  # fmt: skip
    return pd.DataFrame(rows)


def jet_rates() -> pd.DataFrame:
    """Return the depth rates of jets on an inclined plate, mm/s."""
    rows = []
    for mass_rate, angle in itertools.product((1.0, 4.0), (25.0, 45.0)):
        setup = CONVEYOR.setup(
            pair_interaction=PARTICLES, mass_rate=mass_rate, fall_height=0.15, duration=2.0,
            sample_interval=0.02,
        )  # fmt: skip
        result = run_jet(CONVEYOR.case(plate_angle=angle, particle_velocity_y=-0.5, seed=1), setup)
        rate = rate_of(result)
        depth = ARCHARD_CONSTANT * _MM / setup.plate_area
        rows.append(
            {"scene": f"jet of {mass_rate:g} kg/s on {angle:g} deg",
             "depth_rate": rate.value * depth, "depth_stderr": rate.stderr * depth}
        )  # fmt: skip
    return pd.DataFrame(rows)


class Turns:
    """Recorder of the wear of each cell (J, W = 1), particles present and removed, each turn."""

    interval = TURN

    def __init__(self):
        self.worn: list[np.ndarray] = []
        self.present: list[int] = []
        self.removed: list[int] = []

    def record(self, time, problem, state):
        """Keep the sums at the end of a revolution."""
        tally = state.tally[0]
        self.worn.append(state.facet_wear[WEAR_MEASURES.index(MEASURE), :, 0].copy())
        self.present.append(int(tally["placed"] - tally["removed"]))
        self.removed.append(int(tally["removed"]))


def screw_setup(feed: float = FEED, turns: float = FILLING_TURNS + TURNS) -> Setup:
    """Return the set-up of the filled screw, with its surface."""
    setup = CONVEYOR.setup(
        geometry=SCREW, pair_interaction=PARTICLES, mass_rate=feed, fall_height=0.1,
        patch_length=0.06, patch_width=0.06, facet_size=0.025, duration=turns * TURN,
        sample_interval=0.05, time_step=None, time_step_fraction=0.12,
    )  # fmt: skip
    values = {"particle_radius": CONVEYOR.radius, "particle_velocity_y": -0.5}
    return prepared(setup, values)


def part_rates(worn: np.ndarray, area: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return depth rates of a part and their standard errors, mm/s, by statistic over its cells.

    Parameters
    ----------
    worn : ndarray, shape (turns, cells)
        Wear in each revolution, J, for W = 1 /Pa.
    area : ndarray, shape (cells,)
        m2.

    Returns
    -------
    dict
        ``mean`` over the part; ``worn cells``: mean over those that were worn at all; ``99th
        percentile``: the rate of the cell that no more than a hundredth of the area exceeds.
    """
    depth = worn / area / TURN * ARCHARD_CONSTANT * _MM
    mean = depth.mean(axis=0)
    order = np.argsort(mean)
    below = np.cumsum(area[order]) / area.sum()
    chosen = {
        "mean": np.ones(area.size, bool),
        "worn cells": mean > 0.0,
        "99th percentile": np.arange(area.size) == order[np.searchsorted(below, 0.99)],
    }
    found = {}
    for name, cells in chosen.items():
        each = depth[:, cells] @ area[cells] / area[cells].sum()
        found[name] = float(each.mean()), float(each.std(ddof=1) / math.sqrt(len(each)))
    return found


def filled_screw() -> pd.DataFrame:
    """Return what the filled screw does: rates of its parts, and how steady and full it is.

    Returns
    -------
    pandas.DataFrame
        A row for each part and statistic of `part_rates`: part, statistic, depth_rate,
        depth_stderr, mm/s, from the revolutions after filling. In all rows, filling: volume of the
        particles over that between shaft and edge of the flight; throughput over feed; drift:
        change of the filling from the first to the second half of the time.
    """
    setup = screw_setup()
    assert setup.surface is not None
    turns = Turns()
    run_jet(CONVEYOR.case(particle_velocity_y=-0.5, seed=1), setup, recorder=turns)
    worn = np.diff(np.array(turns.worn)[-TURNS - 1 :], axis=0)
    area, part = cell_areas(setup.surface), setup.surface.part
    present = np.array(turns.present)[-TURNS:]
    half = TURNS // 2
    left = turns.removed[-1] - turns.removed[-TURNS - 1]
    volume = sphere_volume(CONVEYOR.radius)
    swept = math.pi * (SCREW["radius"] ** 2 - SCREW["shaft_radius"] ** 2) * SCREW["length"]
    rows = [
        {"part": name, "statistic": statistic, "depth_rate": rate, "depth_stderr": error}
        for number, name in enumerate(setup.surface.part_names)
        for statistic, (rate, error) in part_rates(
            worn[:, part == number], area[part == number]
        ).items()
    ]
    return pd.DataFrame(rows).assign(
        filling=present.mean() * volume / swept,
        throughput=left * volume * CONVEYOR.particle.density / (TURNS * TURN) / FEED,
        drift=present[half:].mean() / present[:half].mean() - 1.0,
    )


def screw_checks(found: pd.DataFrame) -> list[Check]:
    """Return the checks of the filled screw, see `filled_screw`."""
    first = found.iloc[0]
    words = (
        f"{SCREW['revolutions']:g} rev/min, {FEED:g} kg/s, wear of {TURNS} revolutions after "
        f"{FILLING_TURNS}; particles fill {100.0 * first['filling']:.0f} % of the volume between "
        "shaft and edge of the flight"
    )
    checks = [
        Check("filled screw: throughput over feed", first["throughput"], 1.0, MOST_DRIFT,
              note=words),
        Check("filled screw: drift of the filling", first["drift"], 0.0, MOST_DRIFT,
              kind="absolute", note=words),
    ]  # fmt: skip
    for part, rows in found.groupby("part", sort=False):
        if part not in JUDGED_PARTS:
            continue
        all_rates = ", ".join(
            f"{row.statistic} {row.depth_rate:.2g} +- {row.depth_stderr:.1g}"
            for row in rows.itertuples()
        )
        judged = rows.set_index("statistic").loc[JUDGED, "depth_rate"]
        checks.append(
            Check(f"filled screw, {part}: log10 of the depth rate (mm/s), {JUDGED} of its area",
                  math.log10(judged), math.log10(PUBLISHED), 1.0, kind="absolute",
                  note=f"{part}: {all_rates} mm/s beside an order of {PUBLISHED:g} mm/s; {words}")
        )  # fmt: skip
    return checks


def study() -> dict[str, pd.DataFrame]:
    """Return the tables of this part."""
    screw = filled_screw()
    rates = pd.concat([filling(), jet_rates()], ignore_index=True)
    low, high = rates["depth_rate"].min(), rates["depth_rate"].max()
    middle = float(np.exp(np.log(rates["depth_rate"]).mean()))
    words = f"band of the assumed loads {low:.2g} to {high:.2g} mm/s"
    checks = [
        *screw_checks(screw),
        Check("screw conveyor: log10 of the depth rate (mm/s), middle of the assumptions",
              math.log10(middle), math.log10(PUBLISHED), 1.0, kind="absolute",
              note=f"{words}; tests the order of magnitude only"),
        Check("screw conveyor: the band holds the published order", float(low <= PUBLISHED <= high),
              1.0, kind="at least", note=words),
    ]  # fmt: skip
    screw = screw.assign(scene="filled screw, " + screw["part"] + ", " + screw["statistic"])
    drawn = screw[screw["part"].isin(JUDGED_PARTS) & screw["statistic"].isin(["mean", JUDGED])]
    shown = pd.concat([drawn[list(rates.columns)], rates], ignore_index=True)
    return {"checks": checks_table(PART, checks), "rates": shown}
