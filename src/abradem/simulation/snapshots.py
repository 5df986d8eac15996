"""Snapshots of one case at regular intervals, as tables: particles, contacts, wear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from abradem.dem.model import Case, Setup
from abradem.geometry.build import prepared
from abradem.quantities import WEAR_MEASURES
from abradem.store.columns import SNAPSHOTS
from abradem.store.tables import write_table

TABLES = ("particles", "contacts", "wear")

PLATE = -1
"""Number of the plate among the partners of a contact."""


class Recorder:
    """Recorder for `abradem.simulate` that collects snapshots.

    Parameters
    ----------
    interval : float
        Time between snapshots, s.
    """

    def __init__(self, interval: float):
        self.interval = interval
        self._parts: dict[str, list[pd.DataFrame]] = {name: [] for name in TABLES}

    def record(self, time: float, problem, state) -> None:
        """Take a snapshot; called by the engine."""
        from abradem.dem.state import FLYING, GONE

        step = int(state.tally["step"][0])
        particles = state.particles[: int(state.tally["live"][0])]
        present = particles[particles["motion"] != GONE]
        # In flight, only the vertical velocity differs from that of the anchor.
        flown = np.where(present["motion"] == FLYING, step - present["anchor_step"], 0)
        fall = problem.gravity * problem.dt * flown
        frame = pd.DataFrame({"particle": present["identity"]})
        for name in ("x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"):
            frame[name] = present[name]
        frame["vy"] -= fall
        self._add("particles", time, frame)

        on_plate = particles[(particles["motion"] != GONE) & (particles["plate_stiffness"] != 0.0)]
        pairs = state.pairs[: int(state.tally["pairs"][0])]
        pairs = pairs[pairs["stiffness"] != 0.0]
        plate = _contacts(on_plate["identity"], np.full(on_plate.size, PLATE), on_plate, "plate_")
        between = _contacts(
            particles["identity"][pairs["i"]], particles["identity"][pairs["j"]], pairs, ""
        )
        self._add("contacts", time, pd.concat([plate, between], ignore_index=True))

        # The cells of a surface are a column of facets.
        worn = state.facet_wear.reshape(*state.facet_wear.shape[:2], -1)
        facet_x, facet_z = np.indices(worn.shape[1:], dtype=np.int32)
        wear = pd.DataFrame({"facet_x": facet_x.ravel(), "facet_z": facet_z.ravel()})
        for index, measure in enumerate(WEAR_MEASURES):
            wear[f"wear_{measure}"] = worn[index].ravel().copy()
        self._add("wear", time, wear)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the snapshots, one table for each of `TABLES`."""
        return {name: pd.concat(parts, ignore_index=True) for name, parts in self._parts.items()}

    def _add(self, name: str, time: float, frame: pd.DataFrame) -> None:
        frame.insert(0, "time", time)
        self._parts[name].append(frame)


def _contacts(particle, partner, memory, prefix) -> pd.DataFrame:
    frame = pd.DataFrame({"particle": particle, "partner": partner})
    frame["normal_force"] = memory[f"{prefix}fn"]
    for axis in "xyz":
        frame[f"tangential_force_{axis}"] = memory[f"{prefix}t{axis}"]
    return frame


def write_snapshots(
    case: Mapping[str, Any], setup: Setup, folder: str | Path, interval: float
) -> None:
    """Simulate a case and write ``particles``, ``contacts`` and ``wear`` as Parquet.

    Parameters
    ----------
    case : mapping
        Arguments of `abradem.Case`, and the quantities of the geometry that are sampled.
    setup : Setup
    folder : path-like
        Folder for ``particles.parquet``, ``contacts.parquet`` and ``wear.parquet``.
    interval : float
        Time between snapshots, s.
    """
    from abradem.dem import simulate

    recorder = Recorder(interval)
    simulate(Case.from_row(case), prepared(setup, case), recorder=recorder)
    for name, frame in recorder.tables().items():
        write_table(frame, Path(folder) / f"{name}.parquet", extra=SNAPSHOTS)


def write_scene(
    case: Mapping[str, Any], setup: Setup, folder: str | Path, duration: float, interval: float
) -> None:
    """Simulate a case for a given time and write its snapshots, see `write_snapshots`.

    Parameters
    ----------
    case, setup, folder
        See `write_snapshots`.
    duration, interval : float
        Simulated time, and time between snapshots, s.
    """
    write_snapshots(case, replace(setup, duration=duration), folder, interval)
