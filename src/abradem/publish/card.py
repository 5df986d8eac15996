"""The data card: what a reader of the data set has to know, as the README of the folder."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from abradem.publish.description import (
    LICENCE,
    LICENCE_NAME,
    LICENCE_URL,
    PARTITIONED,
    Description,
    File,
)
from abradem.quantities import FEATURE_NAMES, QUANTITIES, SAMPLED
from abradem.words.labels import LABELS

STEP_BIAS = {
    0.15: "total by at most 0.9 %, sliding by 1.1 %, friction by 0.5 %",
    0.2: "total by at most 1.7 %, sliding by 2.6 %, friction by 0.8 %",
}
"""Largest bias of the mean rates by the time step, as a share of the Rayleigh time: over angles,
speeds and restitutions of single impacts and in a dilute jet, from the verification study."""

BEDS = (
    "On nearly level plates small particles lie in a bed that shields the plate and may fill for many "
    "seconds. A rate is taken when wear and particles present have stopped to change by more than "
    "20 %; of beds that were simulated for longer, single ones were off by up to 8 %, which is "
    "more than their standard error says."
)
"""What is known of the rates of beds: benchmarks/windows.py, docs/method.md."""

FLAGS = {
    "overlap": "an overlap exceeded 5 % of the radius, which strains the contact law",
    "shortfall": "less than 95 % of the feed found room at the factory",
    "stderr": "the relative standard error is above the one aimed at",
    "unsteady": "no steady state was reached, or the record still drifts at its end",
}
"""Words of the column ``quality``, see `abradem.wear.rates.quality`."""


def card(description: Description) -> str:
    """The card as Markdown."""
    sections = (
        _head, _content, _measure, _making, _quantities, _columns, _quality, _limits, _rights,
    )  # fmt: skip
    return "\n".join("\n".join(section(description)) + "\n" for section in sections)


def _head(said: Description) -> Iterable[str]:
    rows = len(said.dataset)
    drawn = rows + len(said.failures)
    target = said.dataset["wear_total_mean"]
    return [
        f"# {said.title}",
        "",
        said.abstract,
        "",
        f"{rows} cases of {drawn} drawn; plate-mean wear depth rates from {target.min():.3g} to "
        f"{target.max():.3g} mm/s. Version {said.version} of {said.date}. {LICENCE}.",
    ]


def _content(said: Description) -> Iterable[str]:
    alone = [file for file in said.files if file.folder not in PARTITIONED]
    lines = ["## Files", "", "| file | what it is | bytes |", "| --- | --- | ---: |"]
    lines += [_row(file.name, file.words, file.size) for file in alone if not file.folder]
    lines += ["| `croissant.json`, `ro-crate-metadata.json` | descriptors for programs | |"]
    for folder, words in PARTITIONED.items():
        parts = [file for file in said.files if file.folder == folder]
        if parts:
            name = f"{folder}/block=*/*.parquet"
            lines.append(_row(name, f"{words}: {len(parts)} files", _size(parts)))
    for folder in sorted({file.folder for file in alone} - {""}):
        files = [file for file in alone if file.folder == folder]
        lines.append(_row(f"{folder}/", f"{len(files)} files", _size(files)))
    return [
        *lines,
        "",
        "Parquet files name unit and meaning of every column in their field metadata. "
        "`ro-crate-metadata.json` holds the SHA-256 of every file.",
    ]


def _measure(said: Description) -> Iterable[str]:
    return [
        "## Wear measure it",
        "",
        "```python",
        "import pandas as pd",
        "",
        'cases = pd.read_parquet("dataset.parquet")      # one row for each case',
        'cases = pd.read_parquet("dataset")              # the same rows, from the parts',
        "```",
        "",
        "`pyarrow.dataset.dataset(\"dataset\", partitioning=\"hive\")`, "
        "`polars.scan_parquet(\"dataset/**/*.parquet\", hive_partitioning=True)` and, in DuckDB, "
        "`from read_parquet('dataset/*/*.parquet', hive_partitioning = true)` read the parts too; "
        "`block` then comes from the names of the folders.",
    ]  # fmt: skip


def _making(said: Description) -> Iterable[str]:
    setup, sampling = said.setup, said.config["sampling"]
    plate = f"{1e3 * setup['plate_length']:g} x {1e3 * setup['plate_width']:g} mm"
    feed = (
        f"{setup['mass_rate']:g} kg/s"
        if setup["mass_rate"]
        else f"{setup['number_rate']:g} particles per second"
    )
    contact = ", ".join(f"{key}: {value}" for key, value in sorted(setup["contact"].items()))
    versions = ", ".join(f"{k} {v}" for k, v in sorted(said.versions["versions"].items()))
    pair = (
        "Spheres meet each other with the coefficients with which they meet the plate."
        if setup["pair_interaction"] is None
        else f"Spheres meet each other with {dict(setup['pair_interaction'])}."
    )
    return [
        "## How it was made",
        "",
        f"Spheres of one radius fall from a patch, the factory, of "
        f"{1e3 * setup['patch_length']:g} x {1e3 * setup['patch_width']:g} mm, "
        f"{1e3 * setup['fall_height']:g} mm above the centre of a plate of {plate}, fed at {feed}. "
        "Their contacts follow Hertz and Mindlin with damping, Coulomb and rolling friction "
        f"({contact}). {pair} The time step is {setup['time_step_fraction']:g} of the Rayleigh "
        "time. Worn volume is Archard's: constant times normal force times distance, in three "
        "wear measures of distance: *total*, all tangential motion under load; *sliding*, only while "
        "Coulomb's limit is active; *friction*, friction work over the coefficient of friction. "
        f"The plate is divided into facets of {1e3 * setup['facet_size']:g} "
        "mm. A rate is the slope of the worn volume in the steady state, from batch means; a case "
        f"runs for at least {setup['window']:g} s of it, until its relative standard error is "
        f"below {setup['target_stderr']:g} or {setup['max_time']:g} s are over.",
        "",
        f"Parameters were drawn by `{sampling['method']}` in {sampling['blocks']} blocks of "
        f"{sampling['cases_per_block']}, seed {said.config['seed']}, each quantity evenly over its "
        "range and independent of the others. `config.yaml` holds every option.",
        "",
        f"Software: {versions}. `versions.json` also holds a hash of the code of each step. The "
        "same configuration, seed and code give the same numbers on any number of cores.",
    ]


def _quantities(said: Description) -> Iterable[str]:
    lines = [
        "## Ranges drawn from",
        "",
        "| | column | unit | from | to | what it is |",
        "| --- | --- | --- | ---: | ---: | --- |",
    ]
    for row in SAMPLED:
        drawn = said.config["sampling"]["ranges"][row.config_key]
        low, high = (float(f"{bound * row.config_factor:.6g}") for bound in drawn)
        lines.append(
            f"| {row.symbol} | `{row.name}` | {row.unit} | {low:g} | {high:g} | {LABELS[row.name].long_name} |"
        )
    return lines


def _columns(said: Description) -> Iterable[str]:
    symbols = {row.name: row.symbol for row in QUANTITIES if row.name in FEATURE_NAMES}
    table = next(file for file in said.files if file.name == "dataset.parquet")
    lines = [
        "## Columns of dataset.parquet",
        "",
        "| column | unit | lowest | median | highest | what it is |",
        "| --- | --- | ---: | ---: | ---: | --- |",
    ]
    for name, dtype, unit, words in table.columns:
        middle = ["", "", ""]
        if dtype != "string" and name not in ("case_id", "block", "seed"):
            values = said.dataset[name]
            middle = [_number(value) for value in (values.min(), values.median(), values.max())]
        symbol = f"{symbols[name]}: " if name in symbols else ""
        lines.append(f"| `{name}` | {unit} | {' | '.join(middle)} | {symbol}{words} |")
    return lines


def _quality(said: Description) -> Iterable[str]:
    flags = said.summary["flags"]
    return [
        "## Quality",
        "",
        f"{said.summary['cases_without_flag']} cases have `quality` = `ok`. The others keep their "
        "row; leave them out where it matters:",
        "",
        "| flag | cases | meaning |",
        "| --- | ---: | --- |",
        *(f"| `{flag}` | {flags.get(flag, 0)} | {words} |" for flag, words in FLAGS.items()),
    ]


def _limits(said: Description) -> Iterable[str]:
    relative = said.dataset["wear_total_mean_stderr"] / said.dataset["wear_total_mean"]
    untouched = int(np.sum(said.dataset["wear_total_p99"] == 0.0))
    noise = said.noise
    step = said.setup["time_step_fraction"]
    bias = STEP_BIAS.get(step)
    reasons = said.failures["status"].value_counts()
    return [
        "## Known limits",
        "",
        "- **Noise.** The relative standard error of `wear_total_mean` is "
        f"{relative.median():.2%} in the median and {relative.quantile(0.95):.2%} at the 95th "
        f"percentile. {noise['cases']} cases of large particles simulated again with other seeds "
        f"({noise['replicates']} runs) show that no model of this column can exceed R2 = "
        f"{noise['r2_floor']:.5f} ({noise['r2_floor_band'][0]:.5f} to "
        f"{noise['r2_floor_band'][1]:.5f}). The columns `max` and `p99` rest on a few facets, "
        "are noisier, and depend on the size of the facets"
        + (
            f"; `wear_total_p99` is zero in {untouched} cases, whose particles left most facets "
            "untouched."
            if untouched
            else "."
        ),
        f"- **Beds.** {BEDS}",
        "- **Time step.** "
        + (
            f"At {step:g} of the Rayleigh time it biases {bias}."
            if bias
            else f"The bias at {step:g} of the Rayleigh time was not measured."
        ),
        "- **Failed cases.** "
        + (
            f"{len(said.failures)} cases gave no rate and are missing, not at random; "
            f"`failures.parquet` says why (most often: {reasons.index[0]})."
            if len(said.failures)
            else "None."
        ),
        "- **Physics.** Smooth dry spheres of one radius; a rigid flat plate whose wear does not "
        "change its shape; wear proportional to Archard's constant, which does not act on the "
        "motion; no fracture, no plasticity, no temperature. Which reading of Archard's law a "
        "metal follows is an open question: the three differ.",
        "- **Ranges.** Quantities were drawn independently, so that most rows are no real "
        "material. Nothing is known outside the ranges, and a model of these rows should not be "
        "trusted there.",
        "- **Rates are simulated**, checked against closed forms, published tests and other "
        "codes, not against wear measured in this arrangement.",
    ]


def _rights(said: Description) -> Iterable[str]:
    return [
        "## Licence and citation",
        "",
        f"[{LICENCE_NAME} ({LICENCE})]({LICENCE_URL}): use it for anything, and name its source:",
        "",
        f"> {said.citation}",
        "",
        "```bibtex",
        said.bibtex,
        "```",
        "",
        "The programs that made it are under a licence of their own (MIT).",
    ]


def _number(value: float) -> str:
    return f"{value:.4g}" if 1e-3 <= abs(value) < 1e5 else f"{value:.3g}"


def _row(name: str, words: str, size: int) -> str:
    return f"| `{name}` | {words} | {size} |"


def _size(files: Iterable[File]) -> int:
    return sum(file.size for file in files)
