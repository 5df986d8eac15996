"""The caption of a figure is in its files, and not in the picture."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from abradem.figures import style
from abradem.figures.captions import caption_in_rst, caption_of
from abradem.figures.gallery_page import page, shrink
from abradem.figures.score_axis import LEAST, MOST, label_scores, unexplained

TEX = r"wear of $\varphi$ = 45°; $R^2$ of 20 splits_"
PLAIN = "Wear of φ = 45°; R² of 20 splits_."


def drawn(captioned):
    with style.style():
        figure, (panel,) = style.panels(1, 1, 1.0, style.COLUMN)
        panel.plot([0, 1], [0, 1])
        if captioned:
            style.caption(figure, TEX)
    return figure


@pytest.fixture
def saved(tmp_path):
    style.save(drawn(True), tmp_path / "a", ("png", "pdf", "svg"))
    return tmp_path


def test_every_format_holds_the_caption(saved):
    assert caption_of(saved / "a.png") == caption_of(saved / "a.pdf") == PLAIN
    # Text of a PDF is UTF-16 where it is not ASCII.
    assert PLAIN.encode("utf-16-be") in (saved / "a.pdf").read_bytes().replace(b"\\", b"")
    texts = ET.parse(saved / "a.svg").getroot().itertext()
    assert any(text.strip() == PLAIN for text in texts)


def test_the_picture_is_the_same_without_a_caption(saved):
    style.save(drawn(False), saved / "b", ("png",))
    with Image.open(saved / "a.png") as one, Image.open(saved / "b.png") as other:
        assert np.array_equal(np.asarray(one), np.asarray(other))
    assert caption_of(saved / "b.png") == "" == caption_in_rst(saved / "missing.png")


def test_the_caption_is_plain_text_in_the_report_and_in_the_gallery(saved):
    assert caption_in_rst(saved / "a.pdf") == r"Wear of φ \= 45°\; R² of 20 splits\_\."
    shrink(saved / "a.png", saved / "small.png")
    assert caption_of(saved / "small.png") == PLAIN
    assert PLAIN.replace("_", r"\_") in page({"maps"}, {"maps": PLAIN})
    assert PLAIN not in page({"maps"})


def test_a_text_below_a_picture_that_stands_alone_is_drawn():
    figure = drawn(True)
    style.write_below(figure, figure.get_label())
    assert PLAIN in figure.get_supxlabel().replace("\n", " ")


def test_the_axis_of_scores_is_labelled_with_the_scores():
    with style.style():
        _, (panel,) = style.panels(1, 1, 1.0, style.PAGE)
        panel.set_xscale("log")
        panel.set_xlim(MOST, 0.02)
        label_scores(panel.xaxis, 0.02, MOST)
    found = {
        float(tick): text.get_text()
        for tick, text in zip(panel.get_xticks(), panel.get_xticklabels(), strict=True)
    }
    assert found[2.0] == "−1" and found[1.0] == "0" and found[0.1] == "0.9"
    for place, text in found.items():
        assert 1.0 - place == pytest.approx(float(text.replace("−", "-")))


def test_unexplained_shares_end_where_the_axes_end():
    shown = unexplained([0.9, 1.0, -50.0, np.nan])
    np.testing.assert_allclose(shown, [0.1, LEAST, MOST, np.nan])
    assert unexplained(-0.5, most=1.0) == 1.0
