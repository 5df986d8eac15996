"""A table of cases on a curved chute with a planted law, and the models that learned it."""

import numpy as np
import pandas as pd

from abradem.config import Config, setup_dict
from abradem.dataset.features import derive
from abradem.learning.evaluation import Results
from abradem.learning.physical.distil import Settings, surrogate_of
from abradem.learning.physical.intervals import conformal_of, hold_out_in_turn
from abradem.learning.physical.local_wear import with_meaning
from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.problem import problem
from abradem.learning.physical.training_domain import with_domain
from abradem.quantities import SAMPLED
from abradem.surrogate.groups import jet_of, wear_scale

CONFIG = Config(
    study="arc",
    simulation={
        "geometry": {
            "kind": "arc",
            "arc": {"radius_mm": [250, 1000], "begin": 80, "end": [20, 40], "width_mm": 300},
        },
    },
)
JET = jet_of(setup_dict(CONFIG))
TARGET = "wear_friction_mean"
VARIED = {
    "arc_radius": (0.25, 1.0), "arc_end": (20.0, 40.0), "particle_velocity_y": (-6.0, -2.0),
    "archard_constant": (1e-9, 9e-9),
}  # fmt: skip
RADIUS_EXPONENT, END_SLOPE, NUMBER = -0.8, 0.7, 0.05
"""The planted wear number is NUMBER (r/H)^RADIUS_EXPONENT exp(END_SLOPE end), the angle in rad."""

FIXED = {
    row.name: sum(row.paper_range) / 2.0 for row in SAMPLED if row.name not in VARIED
} | {"plate_angle": 0.0, "factory_angle": 0.0}  # fmt: skip


def closed_form(values):
    """The planted wear depth rate, mm/s."""
    number = (values["arc_radius"] / JET.fall_height) ** RADIUS_EXPONENT
    number = NUMBER * number * np.exp(END_SLOPE * np.radians(values["arc_end"]))
    return wear_scale(values, JET) * number


def planted(n=60, scatter=0.01, seed=3):
    """``n`` cases with features, quantities of the arc and the planted wear with its scatter."""
    rng = np.random.default_rng(seed)
    cases = pd.DataFrame({name: rng.uniform(*ends, n) for name, ends in VARIED.items()})
    cases = cases.assign(**FIXED)
    table = derive(cases).assign(
        case_id=np.arange(n), arc_radius=cases["arc_radius"], arc_end=cases["arc_end"]
    )
    wear = closed_form(cases) * np.exp(scatter * rng.standard_normal(n))
    return table.assign(**{TARGET: wear, f"{TARGET}_stderr": scatter * wear})


def trained(table, settings=None):
    """Problem, Gaussian process and the two parts of the surrogate of a table."""
    given = problem(table, JET, TARGET, "arc")
    rows = np.arange(len(table))
    process = fitted(makers(1)[PROCESS], given, rows)
    settings = settings or Settings(4000, (32, 32), 40)
    conformal = conformal_of(given, rows, hold_out_in_turn(given, rows, 5, 1))
    model = surrogate_of(given, process, conformal, settings, Results(given.table))
    model = with_meaning(with_domain(model, process, given), True, True, cells=True)
    return given, process, model
