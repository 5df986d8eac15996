"""Figure of the verification study: the chute of a plate, an arc and a plate beside other codes."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from abradem.figures import style

_MARKERS = ("o", "s", "^", "v")


def chute_figure(chutes: pd.DataFrame) -> Figure:
    """Normal impulse on each segment of the chute: this engine and each other code.

    Parameters
    ----------
    chutes : pandas.DataFrame
        The table of `abradem.verification.chutes.compare_chutes`.
    """
    profiles = chutes[chutes["quantity"] == "normal_impulse"]
    codes = list(profiles.groupby(["code", "variant"], sort=False))
    with style.style():
        figure, panels = style.panels(len(codes), 2, 2.2)
        for index, (panel, ((code, _), part)) in enumerate(zip(panels, codes, strict=True)):
            segment = part["segment"] + 1
            panel.bar(segment, part["ours"], color=style.BLUE, alpha=0.4, label="this engine")
            panel.errorbar(
                segment, part["ours"], 2.0 * part["spread"], fmt="none", ecolor=style.BLUE, lw=0.8
            )
            panel.plot(segment, part["reference"], _MARKERS[index], color=style.RED, ms=3.5,
                       label=code)  # fmt: skip
            panel.set_title(code, loc="left")
            panel.set_xlabel("Segment from the upper end on")
            panel.set_ylabel("Normal impulse (N s)")
            panel.set_xticks(np.arange(1, len(part) + 1, 2))
            panel.legend(loc="upper right")
        style.caption(
            figure,
            "segments 1 to 3: upper plate; 4 to 10: arc; 11 to 13: lower plate; bars of error: "
            "twice the spread between jets nudged by 0.1 um",
        )
        return figure
