"""Find the choices of other codes that explain differences from this engine.

    python benchmarks/explain_differences.py

prints, for every code, law and restitution of tests/data/codes, the largest difference of any
quantity (as a share of its largest value over the angles) from an independent integration of the
law: with the choices of this engine, with each choice of the other code alone, and with all of
them.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from abradem.verification import codes
from abradem.verification.plain_impact import Choices, plain_impact
from abradem.verification.scenes import NOMINAL_SPEED

TABLE = Path(__file__).parents[1] / "tests" / "data" / "codes" / "single_impacts.csv"


def worst(part, choices: Choices) -> str:
    """Return the largest difference and its quantity as text."""
    found = []
    for row in part.to_dict("records"):
        scene = codes.scene_of(row["variant"], row["restitution"], row["rolling_friction"])
        found.append(plain_impact(scene, NOMINAL_SPEED, row["angle"], choices)[0])
    shares = {}
    for name in codes.QUANTITIES:
        known = part[name].to_numpy()
        if np.isfinite(known).all():
            ours = np.array([one[name] for one in found])
            shares[name] = np.abs(ours - known).max() / np.abs(known).max()
    name = max(shares, key=shares.get)
    return f"{100.0 * shares[name]:6.2f} % ({name})"


def main() -> None:
    """Print the differences of every code, law and restitution."""
    table = codes.read(TABLE)
    for (code, variant, e), part in table.groupby(["code", "variant", "restitution"], sort=False):
        peer = codes.peer_of(code).choices
        chosen = {
            field.name: getattr(peer, field.name)
            for field in dataclasses.fields(Choices)
            if getattr(peer, field.name) != field.default
        }
        print(f"{code} ({variant}), e = {e:g}")
        print(f"  {'ours':42s}{worst(part, Choices())}")
        for name, value in chosen.items():
            print(f"  {f'{name} = {value}':42s}{worst(part, Choices(**{name: value}))}")
        print(f"  {'all of them':42s}{worst(part, peer)}", flush=True)


if __name__ == "__main__":
    main()
