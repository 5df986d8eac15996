r"""Tables (booktabs) and numbers for a LaTeX text, each with its source in the results.

Every number is looked up in a result file by a short expression, its *place*, which is also
written as a comment next to the number. In JSON and YAML a place is a path, such as
``models.0.r2``. In a table it is a column and a condition on the rows::

    r2 where model=ga_ann, protocol=leakage_free, basis=fixed split
    min wear_total_mean
    count where status=ok

preceded by min, max, median, mean, sum or count if several rows match. ``numbers.tex`` defines one
macro for each number, such as ``\NumberOfCases``; names of macros consist of letters only.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED, held_fixed, scales_of
from abradem.learning.number_text import LARGEST, LOWEST_SCORE, UNDETERMINED, is_number
from abradem.quantities import FEATURE_NAMES, QUANTITIES, SAMPLED, quantity
from abradem.words.escaping import for_latex
from abradem.words.labels import LABELS, POWER_LABELS

MISSING = "--"
"""Printed where there is no such number, such as a score that the paper does not state."""

DERIVATIONS = {
    "particle_youngs_modulus": r"2 G_p (1 + \nu_p)",
    "equipment_youngs_modulus": r"2 G_e (1 + \nu_e)",
    "effective_youngs_modulus": r"\left[(1-\nu_p^2)/E_p + (1-\nu_e^2)/E_e\right]^{-1}",
    "effective_shear_modulus": r"\left[(2-\nu_p)/G_p + (2-\nu_e)/G_e\right]^{-1}",
    "damping_ratio": r"\ln e / \sqrt{\ln^2 e + \pi^2}",
    "damping_coefficient": {
        "table": r"2\sqrt{5/6}\,\xi\sqrt{m k},\ k = \frac43 E^* R",
        "printed": r"-2\,\xi\sqrt{m k},\ k = \frac43 E^* R",
    },
}
"""Formulas of the derived features, see `abradem.dataset.features`."""

_UNITS = {"1": "", "kg/m3": r"kg/m\textsuperscript{3}", "deg": r"\textdegree", "%": r"\%"}

_AGGREGATES: dict[str, Callable[..., Any]] = {
    "min": np.min,
    "max": np.max,
    "median": np.median,
    "mean": np.mean,
    "sum": np.sum,
}


class PlaceError(ValueError):
    """A place that does not exist in a file; the message is one line."""


class Number(NamedTuple):
    """A number as printed, and its source.

    Attributes
    ----------
    text : str
        The number as LaTeX.
    file, place : str
        The file, relative to the folder of the study, and the place in it.
    percent : bool
        Whether the number is multiplied by 100.
    """

    text: str
    file: str
    place: str
    percent: bool = False

    @property
    def source(self) -> str:
        """Text of the comment that states the source."""
        return f"{self.file}: {self.place}{' [x 100]' if self.percent else ''}"


@dataclass(frozen=True)
class CitedResults:
    """The result files of a study from which numbers are cited.

    Parameters
    ----------
    files : mapping of str to DataFrame or plain data
        Tables, and contents of JSON and YAML files, by path relative to the folder of the study.
    """

    files: Mapping[str, Any]

    def value(self, file: str, place: str):
        """The value at a place; raises `PlaceError` if there is no value or more than one."""
        return cited_value(self.files[file], place, file)

    def number(self, file: str, place: str, form: str = "3s", percent: bool = False) -> Number:
        """The number at a place, formatted by `printed`."""
        value = self.value(file, place)
        shown = 100.0 * value if percent and isinstance(value, (int, float)) else value
        return Number(printed(shown, form), file, place, percent)


def cited_value(data, place: str, file: str = "results"):
    """The value at a place, as described in the module docstring.

    Parameters
    ----------
    data : pandas.DataFrame or plain data
    place : str
    file : str
        Name of the file in error messages.

    Raises
    ------
    PlaceError
        If there is no value at the place, or more than one.
    """
    if isinstance(data, pd.DataFrame):
        return _in_table(data, place, file)
    found = data
    for key in place.split("."):
        try:
            found = found[int(key)] if isinstance(found, (list, tuple)) else found[key]
        except (KeyError, IndexError, ValueError, TypeError):
            raise PlaceError(f"{file}: {place}: there is no {key!r}") from None
    return found


def _in_table(table: pd.DataFrame, place: str, file: str):
    what, _, where = place.partition(" where ")
    if what.startswith("count where "):
        what, where = "count", what.removeprefix("count where ")
    rows = table
    for condition in filter(None, where.split(", ")):
        name, _, wanted = condition.partition("=")
        if name not in rows:
            raise PlaceError(f"{file}: {place}: there is no column {name!r}")
        rows = rows[rows[name].map(str) == wanted]
    if what == "count":
        return len(rows)
    aggregate, _, column = what.rpartition(" ")
    if column not in rows:
        raise PlaceError(f"{file}: {place}: there is no column {column!r}")
    values = rows[column].dropna() if aggregate else rows[column]
    if aggregate and aggregate not in _AGGREGATES:
        raise PlaceError(f"{file}: {place}: {aggregate!r} is not one of {', '.join(_AGGREGATES)}")
    if aggregate:
        return float(_AGGREGATES[aggregate](values)) if len(values) else math.nan
    if len(values) != 1:
        raise PlaceError(f"{file}: {place}: {len(values)} rows, expected one")
    value = values.iloc[0]
    return value.item() if isinstance(value, np.generic) else value


def printed(value, form: str) -> str:
    """A value as LaTeX.

    Parameters
    ----------
    value : number, str or list
        None and nan are printed in words, lists with hyphens between their items.
    form : str
        ``d`` for integers, ``2f`` for two decimals, ``2r`` for R2 with two decimals, ``3s`` for
        three significant digits, ``3g`` for three significant digits without trailing zeros,
        ``text`` for text. Large and small numbers are printed with a power of ten; of those that
        no result can have only the bound is printed, see `abradem.learning.number_text`.
    """
    if isinstance(value, (list, tuple)):
        return "-".join(printed(item, form) for item in value)
    if form == "text" or isinstance(value, str):
        return for_latex(str(value))
    if not is_number(value):
        return UNDETERMINED
    lowest = LOWEST_SCORE if form.endswith("r") else -LARGEST
    if value < lowest:
        return f"below {printed(lowest, '3g')}"
    if value > LARGEST:
        return f"above {printed(LARGEST, '3g')}"
    if form == "d":
        if value != int(value):
            raise ValueError(f"{value!r} is not an integer")
        return _signed(f"{int(value):d}")
    digits, kind = int(form[:-1]), form[-1]
    if kind in "fr" and abs(value) < 1e4:
        # Print minus zero as zero.
        return _signed(f"{round(value, digits) + 0.0:.{digits}f}")
    text = f"{value:.{digits}g}"
    if kind == "s":
        plain = value == 0.0 or 1e-2 <= abs(value) < 1e4
        text = f"{value:#.{digits}g}".rstrip(".") if plain else f"{value:.{digits - 1}e}"
    if "e" not in text:
        return _signed(text)
    mantissa, power = text.split("e")
    return rf"\ensuremath{{{mantissa}\times10^{{{int(power)}}}}}"


def _signed(text: str) -> str:
    return rf"\ensuremath{{{text}}}" if text.startswith("-") else text


def parsed(text: str) -> float:
    """The number or the bound from a text made by `printed`; nan for words and for a dash."""
    if text in (MISSING, UNDETERMINED):
        return math.nan
    text = text.removeprefix("below ").removeprefix("above ")
    plain = text.removeprefix(r"\ensuremath{")
    plain = plain.removesuffix("}") if plain != text else plain
    power = re.fullmatch(r"(-?[\d.]+)\\times10\^\{(-?\d+)\}", plain)
    return float(f"{power[1]}e{power[2]}") if power else float(plain)


def resolution(text: str) -> float:
    """Half a unit of the last printed digit, the largest rounding error of a printed number."""
    plain = re.sub(r"\\ensuremath\{|[{}]", "", text)
    mantissa, _, power = plain.partition(r"\times10^")
    decimals = len(mantissa.partition(".")[2])
    return 0.5 * 10.0 ** ((int(power) if power else 0) - decimals)


def numbers_tex(numbers: Mapping[str, Number], study: str) -> str:
    """Content of ``numbers.tex``: one macro for each number, with its source as a comment."""
    wrong = [name for name in numbers if not re.fullmatch(r"[A-Za-z]+", name)]
    if wrong:
        raise ValueError(f"macro {wrong[0]!r}: letters only")
    lines = [f"% Numbers of the study {study}; files are those of results/{study}."]
    lines += [
        rf"\newcommand{{\{name}}}{{{number.text}}} % {number.source}"
        for name, number in numbers.items()
    ]
    return "\n".join(lines) + "\n"


def table_tex(
    columns: str, head: Sequence[str], rows: Iterable[Sequence[str | Number]], study: str
) -> str:
    """A booktabs table; the sources of the numbers follow each row as a comment, in order.

    Parameters
    ----------
    columns : str
        Alignment of the columns, such as ``lrr``.
    head : sequence of str
    rows : iterable of sequence of str or Number
    study : str
    """
    lines = [
        f"% Table of the study {study}; files are those of results/{study}.",
        rf"\begin{{tabular}}{{@{{}}{columns}@{{}}}}",
        r"\toprule",
        " & ".join(head) + r" \\",
        r"\midrule",
    ]
    for row in rows:
        if len(row) != len(head):
            raise ValueError(f"row {row!r} has {len(row)} cells, the head {len(head)}")
        cells = [cell.text if isinstance(cell, Number) else cell for cell in row]
        sources = "; ".join(cell.source for cell in row if isinstance(cell, Number))
        lines.append(" & ".join(cells) + r" \\" + (f" % {sources}" if sources else ""))
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def camel(name: str) -> str:
    """A name as part of a macro: ``ga_ann`` becomes ``GaAnn``; only letters are kept."""
    return "".join(re.sub(r"[^A-Za-z]", "", part).capitalize() for part in name.split("_"))


CONFIG, DATASET, SUMMARY = "config.yaml", "dataset.parquet", "summary.json"
COMPARISON, BESIDE = "learning/comparison.parquet", "learning/beside_paper.parquet"
EXPONENTS = "learning/exponents.parquet"
SCORES, SELECTION = "learning/scores.parquet", "learning/selection.parquet"
NETWORKS = {
    protocol: f"learning/ga_ann_{protocol}.json" for protocol in ("as_published", "leakage_free")
}
CHECKS = "../verification/checks.parquet"

_PROTOCOLS = {"as_published": "Published", "leakage_free": ""}


def study_numbers(results: CitedResults) -> dict[str, Number]:
    """Macros for the numbers that a text on a study would cite.

    Parameters
    ----------
    results : CitedResults
        ``CONFIG``, ``DATASET``, ``SUMMARY``, ``COMPARISON``, ``BESIDE``, ``SCORES`` and
        ``NETWORKS``; ``CHECKS`` if there was a verification.

    Returns
    -------
    dict of str to Number
        By name of the macro.
    """
    number = results.number
    simulated = results.value(SUMMARY, "external") is None
    found = {
        "StudyName": number(CONFIG, "study", "text"),
        "Seed": number(CONFIG, "seed", "d"),
        "NumberOfSplits": number(CONFIG, "learning.repeats", "d"),
        "TestSharePercent": number(CONFIG, "learning.test_share", "4g", True),
        "NumberOfCases": number(SUMMARY, "cases", "d"),
        "NumberOfRows": number(DATASET, "count", "d"),
        "WearRateMeaning": number(SUMMARY, "target_words", "text"),
        "WearRateMin": number(DATASET, f"min {results.value(SUMMARY, 'target')}"),
        "WearRateMax": number(DATASET, f"max {results.value(SUMMARY, 'target')}"),
        "WearRateMedian": number(DATASET, f"median {results.value(SUMMARY, 'target')}"),
    }
    if simulated:
        found |= {
            "NumberOfFailures": number(SUMMARY, "failures", "d"),
            "CasesWithoutFlag": number(SUMMARY, "cases_without_flag", "d"),
            "CasesWithGoodRsquared": number(SUMMARY, "cases_with_good_r2", "d"),
            "GoodRsquared": number(SUMMARY, "good_r2", "2f"),
            "MedianStandardErrorPercent": number(SUMMARY, "median_relative_stderr", "2g", True),
            "SimulatedSeconds": number(DATASET, "sum simulated_time", "5g"),
            **_of_configuration(results),
        }
    return found | _of_models(results) | _of_networks(results) | _of_verification(results)


def _of_configuration(results: CitedResults) -> dict[str, Number]:
    plain = {
        "NumberOfBlocks": "sampling.blocks",
        "PlateLengthMm": "simulation.plate.length_mm",
        "PlateWidthMm": "simulation.plate.width_mm",
        "FacetSizeMm": "simulation.plate.facet_size_mm",
        "PatchLengthMm": "simulation.factory.patch_length_mm",
        "PatchWidthMm": "simulation.factory.patch_width_mm",
        "FallHeightMm": "simulation.factory.fall_height_mm",
        "FeedMassRate": "simulation.factory.mass_rate_kg_s",
        "RayleighFraction": "simulation.time_step_rayleigh_fraction",
        "WindowSeconds": "simulation.stop.window_s",
        "LongestSeconds": "simulation.stop.max_time_s",
        "TargetStandardError": "simulation.stop.target_stderr",
    }
    found = {name: results.number(CONFIG, place, "4g") for name, place in plain.items()}
    for row in SAMPLED:
        for index, end in enumerate(("Min", "Max")):
            place = f"sampling.ranges.{row.config_key}.{index}"
            found[camel(row.config_key) + end] = results.number(CONFIG, place, "4g")
    return found


def _of_models(results: CitedResults) -> dict[str, Number]:
    comparison = results.files[COMPARISON]
    found: dict[str, Number] = {}
    for row in comparison.itertuples(index=False):
        stem = f"Rsquared{camel(row.model)}{_PROTOCOLS.get(row.protocol, camel(row.protocol))}"
        # The first basis of a model and protocol is the main one.
        if stem in found:
            continue
        where = f"where model={row.model}, protocol={row.protocol}, basis={row.basis}"
        for end, column in (("", "r2"), ("Lower", "r2_lower"), ("Upper", "r2_upper")):
            found[stem + end] = results.number(COMPARISON, f"{column} {where}", "2r")
    for row in results.files[BESIDE].itertuples(index=False):
        if math.isfinite(row.printed_r2):
            place = f"printed_r2 where model={row.model}"
            found[f"Rsquared{camel(row.model)}Printed"] = results.number(BESIDE, place, "2r")
    scores = results.files[SCORES]
    for model in dict.fromkeys(scores.loc[scores["protocol"] == "leakage_free", "model"]):
        for metric in ("RMSE", "MAE"):
            where = f"where model={model}, protocol=leakage_free, split=test, metric={metric}"
            name = f"{metric.capitalize()}{camel(model)}"
            found[name] = results.number(SCORES, f"median value {where}")
    return found


def _of_networks(results: CitedResults) -> dict[str, Number]:
    found: dict[str, Number] = {}
    for protocol, file in NETWORKS.items():
        stem = _PROTOCOLS[protocol]
        found |= {
            f"Architecture{stem}": results.number(file, "architecture", "d"),
            f"BestFitness{stem}": results.number(file, "best_fitness", "2r"),
            f"NetworksTrained{stem}": results.number(file, "networks_trained", "d"),
        }
    return found


def _of_verification(results: CitedResults) -> dict[str, Number]:
    if CHECKS not in results.files:
        return {}
    return {
        "VerificationChecks": results.number(CHECKS, "count", "d"),
        "VerificationChecksThatHold": results.number(CHECKS, "count where verdict=holds", "d"),
    }


def quantities_tex(results: CitedResults, study: str) -> str:
    """Table of the quantities: symbol, name, unit, and the sampled range or the formula."""
    form = results.value(CONFIG, "features.damping_coefficient")
    rows: list[list[str | Number]] = []
    for row in QUANTITIES:
        unit = row.config_unit if row.kind == "sampled" else row.unit
        head = [row.symbol, f"${LABELS[row.name].tex}$", LABELS[row.name].long_name, unit_tex(unit)]
        if row.kind == "sampled":
            ends = [
                results.number(CONFIG, f"sampling.ranges.{row.config_key}.{index}", "4g")
                for index in (0, 1)
            ]
            values = np.array([[results.value(CONFIG, end.place)] for end in ends])
            fixed = held_fixed(values)[0]
            rows.append([*head, ends[0], HELD_FIXED if fixed else ends[1], ""])
        else:
            formula = DERIVATIONS.get(row.name, "")
            formula = formula[form] if isinstance(formula, dict) else formula
            if row.kind == "target":
                head[2] = results.number(SUMMARY, "target_words", "text").text
            rows.append([*head, "", "", f"${formula}$" if formula else "simulated"])
    head = ["", "Symbol", "Quantity", "Unit", "Minimum", "Maximum", "Derived from"]
    return table_tex("llllrrl", head, rows, study)


def features_tex(results: CitedResults, study: str) -> str:
    """Table of the features: their range in the data set, and the features of the networks."""
    selection = results.files[SELECTION]
    rows: list[list[str | Number]] = []
    for name in FEATURE_NAMES:
        row = quantity(name)
        marks = []
        for protocol in ("as_published", "leakage_free"):
            mine = selection[(selection["feature"] == name) & (selection["protocol"] == protocol)]
            marks.append(_mark(bool((mine["chosen_by"] != "").any())))
        listed = selection.loc[selection["feature"] == name, "in_paper"]
        values = results.files[DATASET][[name]].to_numpy(dtype=float)
        fixed = held_fixed(values, scales_of([name]))[0]
        rows.append(
            [
                row.symbol, f"${LABELS[row.name].tex}$", LABELS[row.name].long_name,
                unit_tex(row.unit),
                results.number(DATASET, f"min {name}"),
                HELD_FIXED if fixed else results.number(DATASET, f"max {name}"),
                _mark(bool(listed.any())), *marks,
            ]
        )  # fmt: skip
    head = [
        "",
        "Symbol",
        "Feature",
        "Unit",
        "Minimum",
        "Maximum",
        "Paper",
        "As published",
        "Leakage-free",
    ]
    return table_tex("llllrrccc", head, rows, study)


def _mark(chosen: bool) -> str:
    return r"$\bullet$" if chosen else ""


def models_tex(results: CitedResults, names: Mapping[str, str], study: str) -> str:
    """Table of R2 of all models: printed, as published, and leakage-free with its interval."""
    rows: list[list[str | Number]] = []
    comparison = results.files[COMPARISON]
    for row in results.files[BESIDE].itertuples(index=False):
        mine = comparison[comparison["model"] == row.model]
        # A score that does not exist is no score that is not determined.
        exists = {
            "printed_r2": is_number(row.printed_r2),
            "as_published_r2": (mine["protocol"] == "as_published").any(),
            **dict.fromkeys(
                ("leakage_free_r2", "leakage_free_lower", "leakage_free_upper"), bool(row.basis)
            ),
        }
        cells = []
        for column, there in exists.items():
            cell = results.number(BESIDE, f"{column} where model={row.model}", "2r")
            cells.append(cell if there else cell._replace(text=MISSING))
        rows.append([for_latex(names.get(row.model, row.model)), *cells, for_latex(row.basis)])
    head = ["Model", "Printed", "As published", "Leakage-free", "From", "To", "Interval over"]
    return table_tex("lrrrrrl", head, rows, study)


def exponents_tex(results: CitedResults, study: str) -> str:
    """Table of the exponents of the wear rate beside those of the published data."""
    rows: list[list[str | Number]] = []
    for row in results.files[EXPONENTS].itertuples(index=False):
        label = POWER_LABELS[row.quantity]
        cells = [
            results.number(EXPONENTS, f"{column} where quantity={row.quantity}", "2f")
            for column in (
                "exponent", "exponent_stderr", "published_exponent", "published_stderr",
            )
        ]  # fmt: skip
        rows.append([label.long_name, f"${label.tex}$", *cells, for_latex(row.verdict)])
    head = ["Quantity", "Symbol", "Exponent", "Error", "Published", "Error", "Verdict"]
    return table_tex("llrrrrl", head, rows, study)


def verification_tex(results: CitedResults, parts: Mapping[int, str], study: str) -> str:
    """Table of the checks of the verification study by part; without checks, only the head."""
    rows: list[list[str | Number]] = []
    if CHECKS in results.files:
        for part in sorted(set(results.files[CHECKS]["part"])):
            counts = [
                results.number(CHECKS, f"count where part={part}{more}", "d")
                for more in ("", ", verdict=holds")
            ]
            rows.append([for_latex(parts[int(part)]), *counts])
    return table_tex("lrr", ["Part", "Checks", "Hold"], rows, study)


def unit_tex(unit: str) -> str:
    """A unit of `abradem.quantities` as LaTeX."""
    return _UNITS.get(unit, unit)
