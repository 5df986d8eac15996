"""Tables drawn from the ranges of the paper, with a known law."""

import numpy as np
import pandas as pd

from abradem.dataset.features import derive
from abradem.quantities import SAMPLED, TARGET

PLANTED = {"archard_constant": 0.5, "plate_angle": 0.3, "particle_velocity_y": -0.6}
"""Standardised weights of the linear law."""


def drawn(n, seed=0, **fixed):
    """``n`` random cases with features, without wear."""
    rng = np.random.default_rng(seed)
    cases = pd.DataFrame({row.name: rng.uniform(*row.paper_range, n) for row in SAMPLED})
    return derive(cases.assign(**fixed)).assign(case_id=np.arange(n))


def linear_law(n, noise=0.0, seed=0):
    """Wear linear in three features, plus noise, in standard deviations."""
    table = drawn(n, seed)
    wear = 4.0 + sum(
        share * (table[name] - table[name].mean()) / table[name].std(ddof=0)
        for name, share in PLANTED.items()
    )
    noise = noise * np.random.default_rng(seed + 1).standard_normal(n)
    return table.assign(**{TARGET.name: wear + noise})


def product_law(n, noise=0.05, seed=0):
    """Physically plausible wear: W times a function of speed and angle, times noise."""
    table = drawn(n, seed)
    wear = (
        3e6
        * table["archard_constant"]
        * (table["particle_velocity_y"] ** 2 + 5.0)
        * (1.0 + table["plate_angle"] / 40.0)
    )
    noise = np.exp(noise * np.random.default_rng(seed + 1).standard_normal(n))
    return table.assign(**{TARGET.name: wear * noise})


def no_law(n, seed=0):
    """Wear that does not depend on the features."""
    wear = np.random.default_rng(seed + 1).uniform(1.0, 2.0, n)
    return drawn(n, seed).assign(**{TARGET.name: wear})
