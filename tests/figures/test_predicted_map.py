"""The predicted wear map: what it shows, and that it fits its page."""

import numpy as np
from figure_checks import assert_fit_to_print, texts

from abradem.figures.predicted_map import predicted_map_figure
from abradem.quantities import SAMPLED

ROW = {row.name: float(np.mean(row.paper_range)) for row in SAMPLED}
PLATE = {"length": 300.0, "width": 200.0}


def test_the_map_shows_each_element_in_place_and_fits_its_page():
    rate = 1e-3 * np.arange(1.0, 25.0).reshape(6, 4)
    figure = predicted_map_figure(rate, PLATE, ROW, "friction")
    assert_fit_to_print(figure)
    mesh = figure.axes[0].collections[0]
    np.testing.assert_allclose(mesh.get_array().reshape(4, 6).T, 1e3 * rate)
    x, y = (edges.ravel() for edges in np.split(mesh.get_coordinates(), 2, axis=2))
    assert (x.min(), x.max(), y.min(), y.max()) == (-150.0, 150.0, -100.0, 100.0)
    assert "wear measure: friction" in texts(figure).replace("\n", " ")
