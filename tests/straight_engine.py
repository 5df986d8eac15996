"""An engine that takes no time: a cumulative wear that is a straight line, a map that is a ramp."""

import numpy as np

from abradem.dem.model import SimulationResult

STEADY_FROM, END = 0.5, 3.5
RATE = 7.0
"""J/s on the whole plate, all wear measures alike."""
PARTS = 10


def ramp(setup):
    """Share of the wear of every facet, growing along the slope from 1 to nx."""
    nx, nz = setup.facets
    shares = np.repeat(np.arange(1.0, nx + 1.0)[:, None], nz, axis=1)
    return shares / shares.sum()


def straight_line(case, setup, status="ok", steady=True):
    """Return the result of a case; not ``steady``: its window was not completed."""
    time = np.linspace(0.0, END, 176)
    wear = np.repeat(RATE * setup.window * ramp(setup)[None], 3, axis=0)
    nothing = np.full_like(wear, np.nan)
    return SimulationResult(
        case=case,
        setup=setup,
        status=status,
        time=time,
        worn=np.repeat(RATE * time[:, None], 3, axis=1),
        delivered_mass=4.0 * time,
        present=np.full(time.size, 50),
        facet_wear=wear if steady else nothing,
        facet_wear_parts=np.repeat(wear[None] / PARTS, PARTS if steady else 0, axis=0),
        facet_wear_all=wear,
        window=(STEADY_FROM, STEADY_FROM + setup.window) if steady else (np.nan, np.nan),
        steady_from=STEADY_FROM if steady else np.nan,
        settled=steady,
        stderr=0.1,
        time_step=1e-5,
        simulated_time=END,
        requested_rate=4.0,
        delivered_rate=4.0,
        face_share=1.0,
        edge_share=0.0,
        missed_share=0.0,
        max_overlap=0.01,
        released=200,
        removed=180,
        energy={},
        cell_sums=nothing[:0],
        cell_sums_all=nothing[:0],
    )
