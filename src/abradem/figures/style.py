"""Common style of the figures: widths, fonts, colours, panel letters, labels with units, saving.

Figures are made with the Figure class of matplotlib instead of pyplot, without global state or
display. Widths are those of a single and a double column of a journal, text has 6.5 to 8 points at
that width, and the colours are those of Okabe and Ito, which colour-blind readers can distinguish.
"""

from __future__ import annotations

import contextlib
import math
import string
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from abradem.dataset.variation import HELD_FIXED, NOT_IDENTIFIED, VARIED
from abradem.learning.number_text import LARGEST, is_number, number_or_words
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.quantities import quantity
from abradem.store.files import replacing
from abradem.words.escaping import from_mathtext
from abradem.words.labels import LABELS, feature_label

if TYPE_CHECKING:
    import pandas as pd

MM_PER_INCH = 25.4
COLUMN = 85.0 / MM_PER_INCH
"""Width of one column, inches."""
PAGE = 180.0 / MM_PER_INCH
"""Width of two columns, inches."""
DPI = 300
FORMATS = ("pdf", "png")

BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY, YELLOW, BLACK = "#CC79A7", "#56B4E9", "#F0E442", "#000000"
GREY, LIGHT_GREY = "#666666", "#E5E5E5"
PROTOCOL_COLOURS = {AS_PUBLISHED: RED, LEAKAGE_FREE: BLUE}
MODEL_COLOURS = {
    "power_law": GREEN,
    "networks": PURPLE,
    "boosting": ORANGE,
    "gaussian_process": BLUE,
    "stacked": BLACK,
    "surrogate": SKY,
}
"""Colours of the models on dimensionless groups."""
PALETTE = (BLUE, RED, GREEN, PURPLE, ORANGE, SKY, BLACK)
_SETTINGS: Any = {
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "dejavusans",
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "lines.linewidth": 1.0,
    "patch.linewidth": 0.6,
    "legend.frameon": False,
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-3, 4),
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "pdf.compression": 6,
    "savefig.dpi": DPI,
    "figure.dpi": 100.0,
}

_UNITS = {
    "1": "",
    "kg/m3": "kg/m³",
    "m3/s": "m³/s",
    "m3/kg": "m³/kg",
    "deg": "°",
}


@contextlib.contextmanager
def style() -> Iterator[None]:
    """Use the settings of this package on top of the defaults of matplotlib, not the user's."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of ``width`` by ``height`` inches with constrained layout."""
    figure = Figure(figsize=(width, height))
    figure.set_layout_engine("constrained", w_pad=0.05, h_pad=0.05, wspace=0.04, hspace=0.03)
    return figure


def unit_text(unit: str) -> str:
    """A unit as printed; "" for dimensionless quantities."""
    return _UNITS.get(unit, unit)


def with_unit(words: str, unit: str) -> str:
    """Text of an axis label with the unit, if there is one, in brackets."""
    printed = unit_text(unit)
    return f"{words} ({printed})" if printed else words


def axis_label(name: str) -> str:
    """Axis label of a quantity: name, symbol and unit."""
    tex, long_name = LABELS[name]
    return with_unit(f"{long_name[0].upper()}{long_name[1:]} ${tex}$", quantity(name).unit)


def short_label(name: str) -> str:
    """Name and symbol of a quantity, short enough for a tick label."""
    tex, long_name = LABELS[name]
    words = long_name.removeprefix("coefficient of ").removesuffix(" (vertical)")
    return f"{words}  ${tex}$"


def feature_rows(panel: Axes, names: Sequence[str]) -> None:
    """Label the vertical axis with one row for each feature, the first at the top."""
    panel.set_yticks(range(len(names)), [feature_label(name) for name in names], fontsize=6.5)
    panel.tick_params(axis="y", length=0)
    panel.set_ylim(len(names) - 0.4, -0.6)


def name_unvaried(panel: Axes, variation: Iterable[str], upright: bool = False) -> None:
    """Write in place of a bar or a dot why there is none: held fixed, not identified.

    Parameters
    ----------
    panel : matplotlib.axes.Axes
    variation : iterable of str
        Of the rows of the panel, from the first at the top, or if ``upright`` of its columns.
    upright : bool
    """
    for place, says in enumerate(variation):
        if says == VARIED:
            continue
        x, y = (float(place), 0.03) if upright else (0.02, float(place))
        panel.text(
            x, y, says, fontsize=6.5, color=GREY, rotation=90.0 if upright else 0.0,
            transform=panel.get_xaxis_transform() if upright else panel.get_yaxis_transform(),
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
            ha="center" if upright else "left", va="bottom" if upright else "center",
        )  # fmt: skip


def name_fixed(panel: Axes, variation: Iterable[str]) -> None:
    """Name the rows of a panel that were held fixed; the others have a bar."""
    name_unvaried(panel, [says if says == HELD_FIXED else VARIED for says in variation])


def sharing(table: pd.DataFrame) -> str:
    """Words for a caption on features that the rows do not tell apart, or "".

    Parameters
    ----------
    table : pandas.DataFrame
        Holds symbol and variation.
    """
    found = table.loc[table["variation"] == NOT_IDENTIFIED, "symbol"]
    if found.empty:
        return ""
    return f". Not identified, with an arbitrary share: {', '.join(dict.fromkeys(found))}"


def minus(text: str) -> str:
    """The text of a number with hyphens replaced by minus signs."""
    return text.replace("-", "\N{MINUS SIGN}")


def feature_colours(names: Iterable[str]) -> list[str]:
    """Colour of each feature, which depends on whether it is sampled or derived."""
    return [ORANGE if quantity(name).kind == "derived" else BLUE for name in names]


def feature_handles() -> list[Patch]:
    """Legend handles for `feature_colours`."""
    return [
        Patch(color=BLUE, label="sampled feature"),
        Patch(color=ORANGE, label="derived feature (a function of sampled ones)"),
    ]


def letter(index: int) -> str:
    """Panel letter (a), (b), ... in bold, for the beginning of a title."""
    text = ""
    index += 1
    while index:
        index, place = divmod(index - 1, 26)
        text = string.ascii_lowercase[place] + text
    return rf"$\bf{{({text})}}$"


def decade(largest: float) -> int:
    """Power of ten, a multiple of three, that scales ``largest`` to between 1 and 1000."""
    if not (math.isfinite(largest) and largest > 0.0):
        return 0
    return 3 * math.floor(math.log10(largest * (1.0 + 1e-12)) / 3.0)


def scaled_unit(power: int, unit: str) -> str:
    """A unit with the power of ten by which the numbers were divided."""
    return f"$10^{{{power}}}$ {unit_text(unit)}" if power else unit_text(unit)


def number(value: float, digits: int = 3) -> str:
    """A number as printed, with a minus sign and, if necessary, a power of ten."""
    if not is_number(value) or abs(value) > LARGEST:
        return minus(number_or_words(value))
    text = f"{value:.{digits}g}"
    if "e" in text:
        mantissa, power = text.split("e")
        return rf"${mantissa} \times 10^{{{int(power)}}}$"
    return text.replace("-", "\N{MINUS SIGN}")


def with_error(value: float, error: float, unit: str) -> str:
    """A value and its standard error, rounded to two digits of the error, with the unit."""
    if not is_number(value) or abs(value) > LARGEST:
        return minus(number_or_words(value))
    power = math.floor(math.log10(abs(value))) if value else 0
    power = 0 if -2 < power < 3 else power
    value, error = value / 10.0**power, error / 10.0**power
    places = 2
    if math.isfinite(error) and error > 0.0:
        places = min(max(1 - math.floor(math.log10(error)), 0), 6)
    shown = f"{value:.{places}f}"
    if math.isfinite(error):
        shown = f"{shown} ± {error:.{places}f}"
    if power:
        shown = rf"({shown})$\times$$10^{{{power}}}$"
    return f"{shown} {unit_text(unit)}"


def title_case(panel: Axes, index: int, row) -> None:
    """Title of a panel for one case: panel letter, number of the case and main quantities."""
    angle, radius = row["plate_angle"], 1e3 * row["particle_radius"]
    panel.set_title(
        f"{letter(index)} case {row['case_id']:d}\n$\\varphi$ = {angle:.0f}°, "
        f"$R$ = {radius:.0f} mm, $v_y$ = {number(row['particle_velocity_y'], 2)} m/s",
        loc="left",
        fontsize=6.5,
    )


def title_own_case(panel: Axes, row) -> None:
    """Title of a panel for a case that has no number: its main quantities."""
    panel.set_title(
        f"$\\varphi$ = {number(row['plate_angle'])}°, $R$ = {number(1e3 * row['particle_radius'])} "
        f"mm, $v_y$ = {number(row['particle_velocity_y'])} m/s",
        loc="left",
        fontsize=6.5,
    )


_ROOM = 0.35


def panels(count: int, columns: int, height: float, width: float = PAGE) -> tuple[Figure, list]:
    """A figure of ``count`` panels in rows of ``columns``, each row ``height`` inches high.

    Space for the caption and a legend is added to the height.
    """
    columns = max(1, min(columns, count))
    rows = -(-count // columns)
    figure = new_figure(width, height * rows + _ROOM)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for spare in grid[count:]:
        spare.remove()
    return figure, list(grid[:count])


def say_nothing_to_show(panel: Axes, words: str) -> None:
    """Clear a panel and write in it why it is empty."""
    panel.set_axis_off()
    panel.text(
        0.5, 0.5, textwrap.fill(words, 26), transform=panel.transAxes, ha="center", va="center",
        color=GREY, fontsize=7.0,
    )  # fmt: skip


def caption(figure: Figure, text: str) -> None:
    """Give a figure its caption, which is no part of the picture.

    `save` writes it into the metadata of the files, where the report and the gallery find it, see
    `abradem.figures.captions`.
    """
    line = from_mathtext(text).rstrip(".")
    figure.set_label(f"{line[:1].upper()}{line[1:]}.")


def write_below(figure: Figure, text: str) -> None:
    """Write a text below a figure, wrapped to its width, for pictures that stand alone."""
    width = int(_CAPTION_LETTERS_PER_INCH * figure.get_figwidth())
    lines = [
        line
        for part in text.split("\n")
        for line in textwrap.wrap(part, width, break_on_hyphens=False)
    ]
    figure.supxlabel("\n".join(lines), fontsize=6.5, color=GREY)


_CAPTION_LETTERS_PER_INCH = 19.5


def save(figure: Figure, stem: str | Path, formats: Iterable[str] = FORMATS) -> list[Path]:
    """Write a figure and its caption as ``stem.<format>``, without dates.

    Each file is complete or not written. The caption is in the metadata.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    stem : path-like
        Path without suffix.
    formats : iterable of {"pdf", "png", "svg"}

    Returns
    -------
    list of Path
        The files written.
    """
    text = str(figure.get_label())
    metadata = {
        "pdf": {"CreationDate": None, "Creator": "abradem", "Subject": text or None},
        "png": {"Software": None, **({"Description": text} if text else {})},
        "svg": {"Date": None, "Creator": "abradem", "Description": text or None},
    }
    formats = list(formats)
    unknown = [name for name in formats if name not in metadata]
    if unknown:
        raise ValueError(f"format {unknown[0]!r} is unknown; allowed: {', '.join(metadata)}")
    paths = []
    with style():
        mpl.rcParams["svg.hashsalt"] = "abradem"
        for name in formats:
            path = Path(f"{stem}.{name}")
            with replacing(path) as sink:
                figure.savefig(sink, format=name, metadata=metadata[name])
            paths.append(path)
    return paths
