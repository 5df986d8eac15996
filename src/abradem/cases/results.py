"""Simulation of a case of one's own, and its result with wear rates in mm/s, maps and figures.

The numbers are those that a study writes for the same case and set-up, by the same functions
(`abradem.wear.rates`). pandas and matplotlib are imported when a method needs them.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from abradem.dem.model import Case, Setup, SimulationResult
from abradem.geometry.build import prepared, worn_area
from abradem.quantities import (
    SAMPLED_NAMES,
    STATISTICS,
    WEAR_MEASURES,
    impossible,
    stderr_column,
    wear_column,
)
from abradem.units import MM_PER_M
from abradem.words.wear import WearTarget

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


class DepthRate(NamedTuple):
    """A wear depth rate and its standard error, mm/s."""

    rate: float
    stderr: float

    def __str__(self) -> str:
        return f"{self.rate:.4g} ± {self.stderr:.2g} mm/s"


class CaseResult(SimulationResult):
    """A `SimulationResult` that tells wear depth rates with the Archard constant of its case.

    `abradem.simulate` returns it. ``worn`` and the ``facet_wear`` arrays remain those for an
    Archard constant of 1. Methods that need a steady rate raise a ValueError if the case did not
    end normally, or if the window after its transient was not completed.
    """

    def wear_rates(self, element_size: float | None = None, **options) -> pd.Series:
        """Return the row of the data set for this case.

        Parameters
        ----------
        element_size : float, optional
            Edge of the elements of the statistics, m; by default a facet.
        **options
            Further options of `abradem.wear.rates.wear_rates`.

        Returns
        -------
        pandas.Series
            ``wear_<measure>_<statistic>`` and the standard errors ``..._stderr``, mm/s,
            ``worn_volume_rate`` (m3/s), ``wear_per_kg`` (m3/kg), ``quality`` and others.

        Raises
        ------
        ValueError
            If there is no steady rate, or the plate does not consist of such elements.
        """
        from abradem.wear.rates import wear_rates

        self._check_steady()
        return wear_rates(
            **self._tables(),
            cases=self._case_table(),
            setup=self.setup,
            element_size=element_size,
            **options,
        ).iloc[0]

    def wear_rate(
        self,
        measure: str = "total",
        statistic: str = "mean",
        element_size: float | None = None,
    ) -> DepthRate:
        """Return one wear depth rate and its standard error.

        Parameters
        ----------
        measure : {"total", "sliding", "friction"}
            Wear measure.
        statistic : {"mean", "worn", "footprint", "p99", "max"}
            Statistic over the plate: the mean over the plate or over its worn elements, over the
            footprint (the most worn elements with 95 % of the wear), 99th percentile and worst of
            the elements.
        element_size : float, optional
            Edge of the elements, m; by default a facet. Without effect on the mean.

        Returns
        -------
        DepthRate
            mm/s.

        Raises
        ------
        ValueError
            If a name is unknown, there is no steady rate, or the plate does not consist of such
            elements.
        """
        _check_name("measure", measure, WEAR_MEASURES)
        _check_name("statistic", statistic, STATISTICS)
        rates = self.wear_rates(element_size)
        column = wear_column(measure, statistic)
        return DepthRate(float(rates[column]), float(rates[stderr_column(column)]))

    def wear_map(self, measure: str = "total", element_size: float | None = None) -> np.ndarray:
        """Return the wear depth rate of every facet, or of larger elements, in the window.

        Parameters
        ----------
        measure : {"total", "sliding", "friction"}
            Wear measure.
        element_size : float, optional
            Edge of the elements, m; by default a facet.

        Returns
        -------
        ndarray, shape (nx, nz)
            W J / (area time), mm/s (Archard 1953); x is along the slope, z across.

        Raises
        ------
        ValueError
            If the name is unknown, there is no complete window, the plate does not consist of
            such elements, or the set-up has a geometry, which `cells` is for.
        """
        from abradem.wear.rates import element_counts, element_wear

        _check_name("measure", measure, WEAR_MEASURES)
        if self.setup.surface is not None:
            raise ValueError("a geometry has no facets in rows, see cells")
        self._check_steady()
        counts = element_counts(self.setup, element_size)
        work = element_wear(self.facet_wear[WEAR_MEASURES.index(measure)], counts)
        area = self.setup.plate_area / work.size
        return MM_PER_M * self.case.archard_constant * work / (area * self._window_length())

    def cells(self) -> pd.DataFrame:
        """Return the wear of the cells of a geometry.

        Returns
        -------
        pandas.DataFrame
            See `abradem.wear.surface_cells.cell_table`.

        Raises
        ------
        ValueError
            For the plate, or if there is no complete window.
        """
        from abradem.wear.surface_cells import cell_table

        if self.setup.surface is None:
            raise ValueError("the plate has facets, see wear_map; cells are those of a geometry")
        self._check_steady()
        tables = self._tables()
        return cell_table(tables["maps"], tables["runs"], self._case_table(), self.setup)

    def series(self) -> pd.DataFrame:
        """Return the record over time.

        Returns
        -------
        pandas.DataFrame
            ``time`` (s), the mean wear depth of the plate since the start by wear measure,
            ``depth_<measure>`` (mm), ``delivered_mass`` (kg) and ``particles_present``.
        """
        import pandas as pd

        per_joule = MM_PER_M * self.case.archard_constant / worn_area(self.setup)
        return pd.DataFrame(
            {
                "time": self.time,
                **{
                    f"depth_{measure}": per_joule * self.worn[:, place]
                    for place, measure in enumerate(WEAR_MEASURES)
                },
                "delivered_mass": self.delivered_mass,
                "particles_present": self.present,
            }
        )

    def to_frame(self, element_size: float | None = None) -> pd.DataFrame:
        """Return one row with the case, all wear rates and their errors, for a table of cases.

        Parameters
        ----------
        element_size : float, optional
            Edge of the elements of the statistics, m; by default a facet.

        Returns
        -------
        pandas.DataFrame
            The sampled quantities, ``seed``, ``status``, ``simulated_time`` (s), the columns of
            `wear_rates`; these are missing values if the status is not ok.
        """
        from abradem.wear.rates import wear_rates

        rates = wear_rates(
            **self._tables(),
            cases=self._case_table(),
            setup=self.setup,
            element_size=element_size,
        )
        row = self._case_table().assign(status=self.status, simulated_time=self.simulated_time)
        return row.merge(rates, on="case_id", how="left").drop(columns="case_id")

    def plot_map(self, measure: str = "total") -> Figure:
        """Draw the wear depth rate of every facet, or of every cell of a geometry.

        Parameters
        ----------
        measure : {"total", "sliding", "friction"}

        Returns
        -------
        matplotlib.figure.Figure
            Save it with ``figure.savefig("map.png", dpi=300)``.
        """
        from abradem.figures.maps import depth_rate_maps, wear_maps_figure

        _check_name("measure", measure, WEAR_MEASURES)
        if self.setup.surface is not None:
            from abradem.figures.surface_map import surface_map_figure

            return surface_map_figure(self.setup.surface, self.cells(), measure)
        tables = self._tables()
        found = depth_rate_maps(
            tables["maps"], tables["runs"], self._case_table(), self.setup, [_CASE_ID], measure
        )
        return self._titled(wear_maps_figure(*found, _of_plate(measure)))

    def plot_series(self, measure: str = "total") -> Figure:
        """Draw the mean wear depth of the plate against time, with the fitted slope.

        Parameters
        ----------
        measure : {"total", "sliding", "friction"}

        Returns
        -------
        matplotlib.figure.Figure
        """
        from abradem.figures.series import depth_series, series_figure

        _check_name("measure", measure, WEAR_MEASURES)
        tables = self._tables()
        found = depth_series(
            tables["series"], tables["runs"], self._case_table(), self.setup, [_CASE_ID], measure
        )
        return self._titled(series_figure(*found, _of_plate(measure)))

    def _titled(self, figure: Figure) -> Figure:
        """Replace the number of the case by its main quantities."""
        from abradem.figures.style import title_own_case, write_below

        title_own_case(figure.axes[0], vars(self.case))
        write_below(figure, str(figure.get_label()))
        return figure

    def _tables(self) -> dict:
        from abradem.simulation.batch import result_tables

        row = {"case_id": _CASE_ID, "block": 0, "seed": self.case.seed}
        return result_tables(row, self)

    def _case_table(self) -> pd.DataFrame:
        import pandas as pd

        values = {name: getattr(self.case, name) for name in (*SAMPLED_NAMES, "seed")}
        return pd.DataFrame([{"case_id": _CASE_ID, **values}])

    def _window_length(self) -> float:
        return self.window[1] - self.window[0]

    def _check_steady(self) -> None:
        if self.status != "ok":
            raise ValueError(f"there is no wear rate: {self.status}")
        if not self._window_length() > 0.0:
            raise ValueError(
                f"there is no wear rate: in {self.simulated_time:g} s the plate did not wear "
                f"steadily for the window of {self.setup.window:g} s; simulate longer or take a "
                "shorter window"
            )


_CASE_ID = 0


def simulate(
    case: Case,
    setup: Setup | None = None,
    releases=None,
    progress=None,
    recorder=None,
    threads: int = 1,
) -> CaseResult:
    """Pour particles on the plate of ``case`` until its wear rate is accurate enough.

    `abradem.dem.simulate` explains the stop rule.

    Parameters
    ----------
    case : Case
    setup : Setup, optional
        The default is that of `studies/dilute.yaml`.
    releases, progress, recorder, threads : optional
        As for `abradem.dem.simulation.simulate`.

    Returns
    -------
    CaseResult
        ``result.wear_rate()`` is the wear depth rate with its standard error.

    Raises
    ------
    ValueError
        With one line for each value of the case that is impossible, or if the engine refuses the
        case.

    Examples
    --------
    >>> result = abradem.simulate(abradem.Case(plate_angle=45.0, particle_radius=0.02))
    >>> print(result.wear_rate("friction", "max", element_size=0.03))
    """
    from abradem.dem import simulate as run_engine

    if setup is not None:
        setup = prepared(setup, vars(case))
    lines = [impossible(name, getattr(case, name)) for name in SAMPLED_NAMES]
    if problems := [line for line in lines if line]:
        raise ValueError("\n".join(problems))
    watched = {"releases": releases, "progress": progress, "recorder": recorder}
    result = run_engine(case, setup, **watched, threads=threads)
    return CaseResult(
        **{field.name: getattr(result, field.name) for field in dataclasses.fields(result)}
    )


def _of_plate(measure: str) -> WearTarget:
    return WearTarget(wear_column(measure, "mean"))


def _check_name(what: str, name: str, allowed: tuple[str, ...]) -> None:
    if name not in allowed:
        raise ValueError(f"{what} = {name!r} is unknown; allowed: {', '.join(allowed)}")
