"""The model card of a surrogate: its use, what it learned from, and how far it can be trusted.

Follows Mitchell et al. 2019, Model Cards for Model Reporting, FAT* 2019. The same content is
written as JSON for programs and as HTML for readers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import pandas as pd

from abradem.learning.number_text import (
    UNDETERMINED,
    is_number,
    number_or_words,
    percentage,
    score_number,
    score_range,
)
from abradem.quantities import GEOMETRY_UNITS
from abradem.surrogate.geometry_groups import numbers_of, sampled_names, shape_values
from abradem.words.escaping import for_html
from abradem.words.labels import LABELS
from abradem.words.wear import WearTarget

SOFTWARE_LICENCE = "MIT"

INTENDED = (
    "comparison of materials, angles, speeds and sizes, and the choice of cases to simulate",
    "inverse questions: which wear constant, angle, speed or size gives a depth in some hours",
)
NOT_INTENDED = (
    "cases of which abradem predict warns: outside the ranges where it matters, or far from all "
    "training cases",
    "the service life of a machine without a measured wear constant: it is an input",
    "particles that are not round, wet or break; plates that bend, heat up or change shape as they "
    "wear",
)

_JET_UNITS = {
    "fall_height": "m", "gravity": "m/s2", "mass_rate": "kg/s", "number_rate": "1/s",
    "plate_area": "m2", "patch_area": "m2", "angle_acts": "", "arc_radius": "m",
}  # fmt: skip


_OF_PLATE = ("plate_area", "angle_acts", "arc_radius")


def model_card(
    surrogate: Mapping,
    intervals: Mapping,
    ranges: Mapping[str, Sequence[float]] | None,
    failures: pd.DataFrame | None = None,
    regions: pd.DataFrame | None = None,
    software: str = "",
    licence: str | None = None,
    confidence: float = 0.95,
    fresh: Mapping | None = None,
) -> dict[str, Any]:
    """Content of the model card.

    Parameters
    ----------
    surrogate : mapping
        Content of ``surrogate.json``.
    intervals : mapping
        Content of ``intervals.json``.
    ranges : mapping of str to (float, float), or None
        Ranges of the sampled quantities as configured, in the units of `abradem.quantities`; None
        for a table from elsewhere.
    failures : pandas.DataFrame, optional
        Cases without a rate: ``status``.
    regions : pandas.DataFrame, optional
        Coverage by region: words, level, coverage, tested, band_lower, band_upper, in_band and
        joint_lower, joint_upper, in_joint.
    software : str
        Version of abradem.
    licence : str, optional
        Of the simulated data; None for a table from elsewhere.
    confidence : float
        Central share of the splits that the ranges of the scores contain.
    fresh : mapping, optional
        Summary of `abradem.learning.physical.fresh.coverage_of_fresh`; None without fresh cases.
    """
    known = surrogate.get("jet_known", True)
    geometry = surrogate["jet"].get("geometry")
    surface = "a flat plate" if geometry is None else "the geometry of the study"
    return {
        "model": "surrogate",
        "study": surrogate["table"],
        "software": f"abradem {software}".strip(),
        "intended_use": [
            f"wear depth rates of {surface} under a jet of spheres, as "
            + ("the engine simulates them" if ranges is not None else "in the table of the study"),
            *INTENDED,
        ],
        "not_intended": [
            f"another jet or {'plate' if geometry is None else 'geometry'} than "
            + ("the one below" if known else "that of the table, whatever it is")
            + (
                ": feed, patch, fall height, plate and contacts between particles are fixed"
                if geometry is None
                else ": feed, patch, fall height, contacts between particles and what was not "
                "sampled of the geometry are fixed"
            ),
            *NOT_INTENDED,
        ],
        "jet": {
            "known": known,
            "values": {
                name: {"value": value, "unit": _JET_UNITS[name]}
                for name, value in surrogate["jet"].items()
                if value is not None
                and name != "geometry"
                # Those of the plate mean nothing beside a geometry.
                and not (geometry is not None and name in _OF_PLATE)
            },
            **({} if geometry is None else {"geometry": _geometry(geometry)}),
            **(
                {"pair_interaction": surrogate["pair_interaction"]}
                if "pair_interaction" in surrogate else {}
            ),
        },
        "targets": [_target(surrogate), *map(_local, surrogate.get("local", []))],
        "ranges": [_range(feature, ranges) for feature in surrogate["features"]],
        "rows": {
            "trained": surrogate["training_rows"],
            "hash": surrogate["dataset_hash"],
            "simulated": ranges is not None,
            "failed": 0 if failures is None else len(failures),
            "reasons": (
                {} if failures is None
                else {str(k): int(v) for k, v in failures["status"].value_counts().items()}
            ),
        },
        "protocol": {
            "scores": "the networks, distilled again from a Gaussian process fitted to the "
            "training rows of repeated random splits, scored on the test rows; those of the other "
            "places of the plate are of the Gaussian process on rows that were held out in turn",
            "confidence": confidence,
            "intervals": f"Conformal, from the errors of {intervals['rows']} rows held out in turn",
        },
        "distillation_error": surrogate["distillation_error"],
        "coverage": list(intervals["coverage"]),
        "coverage_by_region": [] if regions is None else _regions(regions),
        "coverage_verdict": None if regions is None else intervals["regions"],
        "fresh": None if fresh is None else _fresh(fresh, surrogate),
        "highest_level": intervals["highest_level"],
        "licence": {
            "software": SOFTWARE_LICENCE,
            "model": licence or "that of the table it learned from",
        },
    }  # fmt: skip


def _geometry(geometry: Mapping) -> dict:
    """Kind, and the numbers that are fixed in the study, with their units."""
    sampled = sampled_names(geometry)
    return {
        "kind": shape_values(geometry)["kind"],
        "fixed": {
            name: {"value": value, "unit": GEOMETRY_UNITS[name], "words": LABELS[name].long_name}
            for name, value in numbers_of(geometry).items()
            if name not in sampled and not isinstance(value, str)
        },
    }


def _target(surrogate: Mapping) -> dict:
    scores = {
        name: {key: score[key] for key in ("median", "lower", "upper", "unit")}
        for name, score in surrogate["scores"].get("test", {}).items()
        if name in ("R2", "R2_log", "RMSE", "MAPE")
    }
    return {**_named(surrogate["target"]), "scores": scores}


def _local(one: Mapping) -> dict:
    held = one["held_out"]
    scores = {
        name: {"median": held[name], "lower": None, "upper": None,
               "unit": "mm/s" if name == "RMSE" else "1"}
        for name in ("R2", "R2_log", "RMSE", "MAPE")
    }  # fmt: skip
    return {**_named(one["target"]), "scores": scores}


def _named(target: Mapping) -> dict:
    said = WearTarget.stored(target)
    return {"name": target["name"], "unit": target["unit"], "words": said.explained}


def _range(feature: Mapping, ranges: Mapping[str, Sequence[float]] | None) -> dict:
    return {
        "name": feature["name"],
        "unit": feature["unit"],
        "words": LABELS[feature["name"]].long_name,
        "configured": None if ranges is None else [float(end) for end in ranges[feature["name"]]],
        "in_rows": list(feature["training_range"]),
    }


def _regions(regions: pd.DataFrame) -> list[dict]:
    columns = [
        "words", "level", "coverage", "tested", "band_lower", "band_upper", "in_band",
        "joint_lower", "joint_upper", "in_joint",
    ]  # fmt: skip
    return regions[columns].to_dict("records")


def _fresh(fresh: Mapping, surrogate: Mapping) -> dict:
    """Coverage at each place of the plate on cases that no model saw, with what the rates are."""
    targets = [surrogate["target"], *(one["target"] for one in surrogate.get("local", []))]
    words = {target["name"]: _named(target)["words"] for target in targets}
    return {
        "cases": fresh["cases"],
        "rates": [{**rate, "words": words[rate["target"]]} for rate in fresh["rates"]],
    }


def card_page(card: Mapping) -> str:
    """The card as one page without any other file."""
    title = f"Model card: surrogate of study {card['study']}"
    parts = [
        f"<h1>{for_html(title)}</h1>",
        *_section("For", _list(card["intended_use"])),
        *_section("Not for", _list(card["not_intended"])),
        *_section("Jet", _jet(card["jet"])),
        *_section("What it predicts", _targets(card)),
        *_section("Ranges", _ranges(card["ranges"])),
        *_section("Rows", _rows(card["rows"])),
        *_section("Coverage of the intervals", _coverage(card)),
        *_section("Licence", [
            f"<p>Software: {for_html(card['licence']['software'])}. Model: "
            f"{for_html(card['licence']['model'])}. Made with {for_html(card['software'])}.</p>"
        ]),
    ]  # fmt: skip
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{for_html(title)}</title>\n"
        "<style>body{font-family:sans-serif;max-width:56em;margin:2em auto;padding:0 1em;"
        "line-height:1.5}"
        "div{overflow-x:auto}table{border-collapse:collapse}td,th{padding:.2em .7em;"
        "border-bottom:1px solid #ccc;text-align:left}td.n{text-align:right}</style></head>\n"
        "<body>\n" + "\n".join(parts) + "\n</body>\n</html>\n"
    )


def _section(heading: str, content: Iterable[str]) -> list[str]:
    return [f"<h2>{heading}</h2>", *content]


def _list(lines: Iterable[str]) -> list[str]:
    return ["<ul>", *(f"<li>{for_html(line)}</li>" for line in lines), "</ul>"]


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], texts: int = 1) -> list[str]:
    """A table whose first ``texts`` columns are text, the others numbers."""
    head = "".join(f"<th>{for_html(text)}</th>" for text in heads)
    body = [
        "<tr>" + "".join(
            f"<td{'' if place < texts else ' class=n'}>{for_html(cell)}</td>"
            for place, cell in enumerate(row)
        ) + "</tr>"
        for row in rows
    ]  # fmt: skip
    return ["<div><table>", f"<tr>{head}</tr>", *body, "</table></div>"]


def _jet(jet: Mapping) -> list[str]:
    rows = [
        (
            name.replace("_", " "),
            f"{one['value']:.4g} {one['unit']}" if one["unit"] else one["value"],
        )
        for name, one in jet["values"].items()
    ]
    of = jet.get("geometry")
    if of is not None:
        rows = [("geometry", of["kind"]), *rows]
        rows += [
            (one["words"], f"{one['value']:.4g} {one['unit']}") for one in of["fixed"].values()
        ]
    if "pair_interaction" in jet:
        rows += _pairs(jet["pair_interaction"])
    if jet["known"]:
        return _table(("quantity", "value"), rows)
    return [
        "<p>Not stated for the table that the model learned from. The following values are a "
        "reference, with which the dimensionless groups are computed.</p>",
        *_table(("quantity", "reference"), rows),
    ]


def _pairs(pair: Mapping | None) -> list[tuple[str, str]]:
    """Rows on contacts between particles."""
    if pair is None:
        return [("contact of two particles", "as of particle and surface")]
    return [(f"{name.replace('_', ' ')} of two particles", f"{value:g}")
            for name, value in pair.items()]  # fmt: skip


def _targets(card: Mapping) -> list[str]:
    rows = [
        (
            one["name"],
            one["words"],
            *(_score(one["scores"].get(name)) for name in ("R2", "R2_log")),
            percentage(one["scores"].get("MAPE", {}).get("median"), ".1f"),
        )
        for one in card["targets"]
    ]
    return [
        *_table(("wear rate", "meaning", "R2", "R2 of ln", "mean relative error"), rows, 2),
        f"<p>Scores: {for_html(card['protocol']['scores'])}; median, and in brackets the central "
        f"{percentage(card['protocol']['confidence'])} of the splits. The networks differ from the "
        "Gaussian process by "
        f"{100.0 * card['distillation_error']['rms']:.2g} % (root mean square).</p>",
    ]


def _score(score: Mapping | None) -> str:
    if score is None:
        return UNDETERMINED
    middle, ends = score_number(score["median"]), (score["lower"], score["upper"])
    return f"{middle} ({score_range(ends)})" if all(map(is_number, ends)) else middle


def _ranges(ranges: Iterable[Mapping]) -> list[str]:
    rows = [
        (one["words"], one["unit"], _ends(one["configured"]), _ends(one["in_rows"]))
        for one in ranges
    ]
    return _table(("quantity", "unit", "as configured", "in the rows"), rows, 2)


def _ends(ends: Sequence[float] | None) -> str:
    return "-" if ends is None else f"{ends[0]:.4g} ... {ends[1]:.4g}"


def _rows(rows: Mapping) -> list[str]:
    text = f"{rows['trained']} rows, {'simulated' if rows['simulated'] else 'of a table'}"
    if rows["failed"]:
        reasons = "; ".join(
            f"{count} {for_html(reason)}" for reason, count in rows["reasons"].items()
        )
        text += f". {rows['failed']} more cases gave no rate ({reasons}), not missing at random"
    elif rows["simulated"]:
        text += "; no case failed"
    return [f"<p>{text}. Hash of the rows: <code>{for_html(rows['hash'])}</code>.</p>"]


def _coverage(card: Mapping) -> list[str]:
    overall = [
        ("all rows", str(card["rows"]["trained"]), *_shares(one, *one["band"]), "")
        for one in card["coverage"]
    ]  # fmt: skip
    regions = [
        (
            one["words"],
            str(one["tested"]),
            *_shares(one, one["band_lower"], one["band_upper"]),
            _share_band(one["joint_lower"], one["joint_upper"]),
        )
        for one in card["coverage_by_region"]
    ]
    heads = ("cases", "number", "level", "inside", "expected by chance", "jointly with all regions")
    return [
        *_table(heads, [*overall, *regions]),
        *_verdict(card["coverage_verdict"]),
        f"<p>{for_html(card['protocol']['intervals'])}; the highest level that they can promise is "
        f"{number_or_words(100.0 * card['highest_level'], '.4g')} %.</p>",
        *_fresh_shares(card["fresh"]),
    ]


def _verdict(verdict: Mapping | None) -> list[str]:
    """How many shares by region chance leaves where they are."""
    if verdict is None:
        return []
    return [
        f"<p>{verdict['in_band']} of the {verdict['shares']} shares by region are as expected by "
        f"chance; if the intervals held exactly, {verdict['expected']:.1f} would be on average. "
        f"{verdict['in_joint']} of {verdict['shares']} are in the joint bands, in which all shares "
        "are at once in 95 of 100 studies if the intervals hold exactly.</p>"
    ]


def _fresh_shares(fresh: Mapping | None) -> list[str]:
    """The shares of fresh cases inside their intervals, at each place of the plate."""
    if fresh is None:
        return []
    rows = [
        (
            rate["words"],
            *_shares(one, *one["band"]),
            f"{rate['in_band']} of {rate['shares']} ({rate['expected']:.1f})",
            f"{rate['in_joint']} of {rate['shares']}",
        )
        for rate in fresh["rates"]
        for one in rate["all"]
    ]
    heads = (
        "wear rate", "level", "inside", "expected by chance", "regions as expected",
        "regions in joint bands",
    )  # fmt: skip
    return [
        f"<p>On {fresh['cases']} fresh cases, which were simulated for this test and which no "
        "model saw. The last columns count the shares by region, at all levels, that are as "
        "expected by chance (in brackets: how many would be on average if the intervals held "
        "exactly), and that are in the joint bands, in which all of them are at once in 95 of 100 "
        "tests if the intervals hold exactly.</p>",
        *_table(heads, rows),
    ]


def _shares(one: Mapping, low: float, high: float) -> tuple[str, str, str]:
    """Level, share inside and binomial band in percent."""
    level, inside = 100.0 * one["level"], 100.0 * one["coverage"]
    return f"{level:g} %", f"{inside:.1f} %", _share_band(low, high)


def _share_band(low: float, high: float) -> str:
    """Ends of a band of shares in percent."""
    return f"{100.0 * low:.1f} to {100.0 * high:.1f} %"
