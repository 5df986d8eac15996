"""Requirements that every figure must fulfil, and noisy but steady simulations to draw."""

from unittest import mock

import numpy as np
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from abradem.dem.model import Setup
from abradem.figures import style
from abradem.quantities import SAMPLED

SETUP = Setup(facet_size=0.05, window=2.0)


def study(n, seed=0):
    """Series, maps, runs and cases of ``n`` noisy but steady simulations."""
    rng = np.random.default_rng(seed)
    cases = pd.DataFrame({"case_id": range(n)})
    for row in SAMPLED:
        cases[row.name] = rng.uniform(*row.paper_range, n)
    time = np.arange(0.0, 4.0001, 0.02)
    facet_x, facet_z = (index.ravel() for index in np.indices(SETUP.facets))
    series, maps = [], []
    for key in range(n):
        power = rng.uniform(10.0, 300.0)
        total = np.cumsum(np.where(time > 0.5, rng.gamma(1.0, 0.02 * power, len(time)), 0.0))
        wear = rng.gamma(0.5, 1.0, len(facet_x))
        series.append(
            pd.DataFrame(
                {"case_id": key, "time": time, "worn_total": total, "delivered_mass": 4.0 * time}
            )
        )
        maps.append(
            pd.DataFrame(
                {
                    "case_id": key,
                    "facet_x": facet_x,
                    "facet_z": facet_z,
                    "wear_total": 2.0 * power * wear / wear.sum(),
                }
            )
        )
    series, maps = pd.concat(series), pd.concat(maps)
    for measure, share in (("sliding", 0.4), ("friction", 0.5)):
        series[f"worn_{measure}"] = share * series["worn_total"]
        maps[f"wear_{measure}"] = share * maps["wear_total"]
    runs = pd.DataFrame({"case_id": range(n), "status": "ok"}).assign(
        steady_from=0.5, window_start=0.5, window_end=2.5, delivered_rate=4.0,
        requested_rate=4.0, max_overlap=0.01, simulated_time=4.0,
    )  # fmt: skip
    return series, maps, runs, cases


def texts(figure):
    """All texts of a figure as drawn, and its caption."""
    figure.draw_without_rendering()
    drawn = [text.get_text() for text in figure.findobj(lambda a: hasattr(a, "get_text"))]
    return " ".join([*drawn, figure.get_label()])


def assert_fit_to_print(figure):
    """Nothing extends beyond the page, no texts overlap, and all text is large enough."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    drawn, draw = {}, Text.draw

    def noted(text, *arguments, **options):
        # Texts that are never drawn, such as labels of ticks beyond the axis, do not count.
        drawn[id(text)] = text
        draw(text, *arguments, **options)

    with style.style(), mock.patch.object(Text, "draw", noted):
        figure.draw(renderer)
    page, boxes = figure.bbox, []
    for text in drawn.values():
        box = text.get_window_extent(renderer)
        if not text.get_visible() or not text.get_text().strip():
            continue
        assert text.get_fontsize() >= 6.5, text.get_text()
        assert box.x0 > -1 and box.y0 > -1, text.get_text()
        assert box.x1 < page.width + 1 and box.y1 < page.height + 1, text.get_text()
        boxes.append((text.get_text(), box))
    for i, (words, box) in enumerate(boxes):
        for other_words, other in boxes[i + 1 :]:
            inner = (
                min(box.x1, other.x1) - max(box.x0, other.x0),
                min(box.y1, other.y1) - max(box.y0, other.y0),
            )
            assert min(inner) < 2.0, f"{words!r} lies on {other_words!r}"
