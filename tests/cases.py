"""Cases and a set-up with a very short simulation."""

import numpy as np
import pandas as pd

from abradem.quantities import SAMPLED

SETUP = {"window": 1.0, "max_time": 3.0, "facet_size": 0.15}


def table_of_cases(count=4, rejected=()):
    frame = pd.DataFrame({"case_id": np.arange(count), "block": np.int32(0), "seed": 10})
    for row in SAMPLED:
        low, high = row.paper_range
        frame[row.name] = np.linspace(low, high, count)
    frame["rejected"] = ["too soft" if case in rejected else "" for case in range(count)]
    return frame
