"""The words for a wear rate: its measure, its statistic and the size of the elements.

All texts, captions and tables on the target of a study use `WearTarget`, so that another
``learning.target`` changes them together.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from abradem.quantities import WEAR_COLUMNS, wear_parts
from abradem.words.labels import MEASURE_WORDS, STATISTIC_WORDS

OF_THE_TABLE = "as in the table that the model learned from"
"""Description of a rate whose measure and statistic are not known."""

_OF_ELEMENTS = {
    "worn": "mean over the worn {size} elements",
    "footprint": "mean over the footprint of {size} elements",
    "p99": "99th percentile of {size} elements",
    "max": "worst {size} element",
}
"""Descriptions of the statistics over elements of a known size."""

_OF_CELLS = {
    "mean": "mean over the surface",
    "worn": "mean over the worn cells",
    "footprint": "mean over the footprint",
    "p99": "99th percentile of the cells",
    "max": "worst cell",
}
"""Descriptions of the statistics over the cells of a geometry."""


class WearTarget(NamedTuple):
    """A column of wear rates, such as the target of a study.

    Attributes
    ----------
    name : str
        Column of the data set, one of `abradem.quantities.WEAR_COLUMNS`.
    element_size : float or None
        Edge of the elements of the statistics, m; None if it is not known.
    known : bool
        Whether the name says what the rate is. The rate of a table from elsewhere stands under one
        of the names, without its measure or its statistic being known.
    cells : bool
        Whether the statistics are over the cells of a geometry, which has no elements.
    part : str or None
        Named part of a geometry to which the rate is restricted.
    """

    name: str
    element_size: float | None = None
    known: bool = True
    cells: bool = False
    part: str | None = None

    @classmethod
    def stored(cls, target: Mapping) -> WearTarget:
        """The target of a model as stored in its description."""
        return cls(
            target["name"], target.get("element_size"), target.get("known", True),
            target.get("cells", False), target.get("part"),
        )  # fmt: skip

    @property
    def measure(self) -> str:
        """One of `abradem.quantities.WEAR_MEASURES`."""
        return wear_parts(self.name)[0]

    @property
    def statistic(self) -> str:
        """One of `abradem.quantities.STATISTICS`."""
        return wear_parts(self.name)[1]

    @property
    def has_elements(self) -> bool:
        """Whether the rate depends on the size of the elements, unlike the mean over the plate."""
        return self.statistic in _OF_ELEMENTS

    @property
    def place(self) -> str:
        """Of what place of the plate the rate is, such as "99th percentile of 30 mm elements"."""
        if not self.known:
            return OF_THE_TABLE
        if self.cells:
            if self.part is None:
                return _OF_CELLS[self.statistic]
            return f"{self.of_cells} of the part {self.part}"
        if self.element_size is None or not self.has_elements:
            return STATISTIC_WORDS[self.statistic]
        return _OF_ELEMENTS[self.statistic].format(size=f"{1e3 * self.element_size:g} mm")

    @property
    def of_cells(self) -> str:
        """The statistic over the cells of a part, such as "99th percentile of the cells"."""
        return _OF_CELLS[self.statistic].removesuffix(" over the surface")

    @property
    def words(self) -> str:
        """Short description, such as "wear depth rate, friction, worst 30 mm element"."""
        if not self.known:
            return f"wear depth rate, {OF_THE_TABLE}"
        return f"wear depth rate, {self.measure}, {self.place}"

    @property
    def of_part(self) -> str:
        """The short description for a named part of a surface."""
        return self.words.replace("the plate", "the part")

    @property
    def explained(self) -> str:
        """Description that says what the measure is."""
        if not self.known:
            return f"wear depth rate, {OF_THE_TABLE} (measure and place are not stated)"
        return f"wear depth rate, {self.place} ({MEASURE_WORDS[self.measure]})"


WEAR_WORDS = {column: WearTarget(column).explained for column in WEAR_COLUMNS}
"""Descriptions of the wear rates of the data set, by column."""


def place_of(target: Mapping) -> str:
    """Return of what place a wear rate of a stored model is, such as "mean over the plate"."""
    if target["name"] not in WEAR_WORDS:
        return OF_THE_TABLE
    return WearTarget.stored(target).place
