"""The data card, which describes the data set and is the README of the published folder."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from abradem.dataset.relative_errors import relative_stderr
from abradem.dataset.variation import HELD_FIXED, held_fixed
from abradem.learning.number_text import number_or_words, percentage, score_number, score_range
from abradem.learning.regions import regions_of
from abradem.publish.description import (
    LICENCE,
    LICENCE_NAME,
    LICENCE_URL,
    PARTITIONED,
    Description,
    File,
)
from abradem.quantities import (
    FEATURE_NAMES,
    QUANTITIES,
    SAMPLED,
    SAMPLED_NAMES,
    wear_column,
    wear_parts,
)
from abradem.words.escaping import for_markdown
from abradem.words.labels import LABELS

STEP_BIAS = {
    0.15: "total by at most 0.9 %, sliding by 0.9 %, friction by 0.5 %",
    0.2: "total by at most 1.7 %, sliding by 1.9 %, friction by 0.8 %",
}
"""Largest bias of the mean rates caused by the time step, by the time step as a share of the
Rayleigh time: over angles, speeds and restitutions of single impacts and in a dilute jet, from the
verification study."""

BEDS = (
    "On nearly level plates small particles form a bed that shields the plate and may take many "
    "seconds to fill. A rate is determined when the wear and the number of particles present no "
    "longer change by more than 20 %. Compared with longer simulations of beds, single rates were "
    "off by up to 8 %, which is more than their standard error."
)
"""Accuracy of the rates of beds: benchmarks/windows.py, docs/method.md."""

FLAGS = {
    "overlap": "an overlap exceeded 5 % of the radius, which strains the contact law",
    "shortfall": "less than 95 % of the feed could be placed, although what finds no room waits",
    "stderr": "the relative standard error is above its target",
    "unsteady": "no steady state was reached, or the wear rate still drifts at the end",
}
"""Meaning of the flags in the column ``quality``, see `abradem.wear.rates.quality`."""


def card(description: Description) -> str:
    """The data card as Markdown."""
    sections = (
        _head, _content, _measure, _making, _quantities, _columns, _quality, _limits, _by_region,
        _rights,
    )  # fmt: skip
    return "\n".join("\n".join(section(description)) + "\n" for section in sections)


def _head(said: Description) -> Iterable[str]:
    rows = len(said.dataset)
    drawn = rows + len(said.failures)
    target = said.dataset[said.summary["target"]]
    return [
        f"# {for_markdown(said.title)}",
        "",
        said.abstract,
        "",
        f"{rows} of {drawn} sampled cases; {said.summary['target_words']}: "
        f"{number_or_words(target.min())} to {number_or_words(target.max())} mm/s. "
        f"Version {said.version} of {said.date}. {LICENCE}.",
    ]


def _content(said: Description) -> Iterable[str]:
    alone = [file for file in said.files if file.folder not in PARTITIONED]
    lines = ["## Files", "", "| file | content | bytes |", "| --- | --- | ---: |"]
    lines += [_row(file.name, file.words, file.size) for file in alone if not file.folder]
    lines += ["| `croissant.json`, `ro-crate-metadata.json` | machine-readable descriptors | |"]
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
        "Parquet files state the unit and the meaning of every column in the field metadata. "
        "`ro-crate-metadata.json` contains the SHA-256 of every file.",
    ]


def _measure(said: Description) -> Iterable[str]:
    return [
        "## Reading the data",
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
        "`from read_parquet('dataset/*/*.parquet', hive_partitioning = true)` read the parts as "
        "well; the column `block` is then taken from the names of the folders.",
    ]  # fmt: skip


def _making(said: Description) -> Iterable[str]:
    setup, sampling = said.setup, said.config["sampling"]
    element_size = said.config["wear_rate"]["element_size_mm"]
    plate = f"{1e3 * setup['plate_length']:g} x {1e3 * setup['plate_width']:g} mm"
    feed = (
        f"{setup['mass_rate']:g} kg/s"
        if setup["mass_rate"]
        else f"{setup['number_rate']:g} particles per second"
    )
    if setup.get("unplaced") == "skip":
        feed += f", less what finds no room at the factory (attempts: {setup['attempts']})"
    contact = ", ".join(f"{key}: {value}" for key, value in sorted(setup["contact"].items()))
    versions = ", ".join(f"{k} {v}" for k, v in sorted(said.versions["versions"].items()))
    pair = setup["pair_interaction"]
    pairs = (
        "Contacts between spheres have the same coefficients as contacts with the plate."
        if pair is None
        else f"Contacts between spheres have a restitution of {pair['restitution']:g}, a static "
        f"friction of {pair['static_friction']:g} and a rolling friction of "
        f"{pair['rolling_friction']:g}."
    )
    return [
        "## How it was made",
        "",
        f"Spheres of one radius fall from a patch, the factory, of "
        f"{1e3 * setup['patch_length']:g} x {1e3 * setup['patch_width']:g} mm, "
        f"{1e3 * setup['fall_height']:g} mm above the centre of a plate of {plate}. The feed is "
        f"{feed}. The contact model is Hertz-Mindlin with damping, Coulomb friction and rolling "
        f"friction ({contact}). {pairs} The time step is {setup['time_step_fraction']:g} of the "
        "Rayleigh time. The worn volume follows Archard's law: constant times normal force times "
        "sliding distance. Three wear measures differ in the distance: *total*, all tangential "
        "motion under load; *sliding*, the slip at Coulomb's limit, without what the damper takes; "
        "*friction*, friction work divided by the coefficient of friction. "
        f"The plate is divided into facets of {1e3 * setup['facet_size']:g} mm"
        + (
            ""
            if element_size is None
            else f", and into elements of {element_size:g} mm for all statistics but the mean"
        )
        + ". A wear rate is the "
        "slope of the worn volume in the steady state, with a standard error from batch means. The "
        f"steady state is simulated for at least {setup['window']:g} s, and until the relative "
        f"standard error of the mean `total` is below {setup['target_stderr']:g} or "
        f"{setup['max_time']:g} s are simulated.",
        "",
        f"Parameters were drawn by `{sampling['method']}` in {sampling['blocks']} blocks of "
        f"{sampling['cases_per_block']} with seed {said.config['seed']}, each quantity uniformly "
        "over its range and independently of the others, unless it was held fixed. "
        "`config.yaml` contains all options.",
        "",
        f"Software: {versions}. `versions.json` also contains a hash of the code of each step. The "
        "same configuration, seed and code give the same numbers on any number of cores.",
    ]


def _quantities(said: Description) -> Iterable[str]:
    lines = [
        "## Sampled ranges",
        "",
        "| | column | unit | from | to | quantity |",
        "| --- | --- | --- | ---: | ---: | --- |",
    ]
    for row in SAMPLED:
        drawn = said.config["sampling"]["ranges"][row.config_key]
        low, high = (float(f"{bound * row.config_factor:.6g}") for bound in drawn)
        end = HELD_FIXED if held_fixed(np.array([[low], [high]]))[0] else f"{high:g}"
        lines.append(
            f"| {row.symbol} | `{row.name}` | {row.unit} | {low:g} | {end} | "
            f"{LABELS[row.name].long_name} |"
        )
    return lines


def _columns(said: Description) -> Iterable[str]:
    symbols = {row.name: row.symbol for row in QUANTITIES if row.name in FEATURE_NAMES}
    table = next(file for file in said.files if file.name == "dataset.parquet")
    lines = [
        "## Columns of dataset.parquet",
        "",
        "| column | unit | lowest | median | highest | meaning |",
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
        f"{said.summary['cases_without_flag']} cases have `quality` = `ok`. Flagged cases are "
        "included; exclude them where necessary:",
        "",
        "| flag | cases | meaning |",
        "| --- | ---: | --- |",
        *(f"| `{flag}` | {flags.get(flag, 0)} | {words} |" for flag, words in FLAGS.items()),
    ]


def _limits(said: Description) -> Iterable[str]:
    noise = said.noise
    target = said.summary["target"]
    relative = pd.Series(relative_stderr(said.dataset, target))
    tail = wear_column(wear_parts(target)[0], "p99")
    untouched = int(np.sum(said.dataset[tail] == 0.0))
    step = said.setup["time_step_fraction"]
    bias = STEP_BIAS.get(step)
    reasons = said.failures["status"].value_counts()
    return [
        "## Known limits",
        "",
        "- **Noise.** Each wear rate has a column with its standard error. That of "
        f"`{target}` is, relative to the rate, "
        f"{percentage(relative.median(), '.2f')} in the median and "
        f"{percentage(relative.quantile(0.95), '.2f')} at the 95th "
        f"percentile. {noise['cases']} cases with large particles were simulated again with other "
        f"seeds ({noise['replicates']} runs). "
        + _floor(noise)
        + " The columns `max` and `p99` are based on a few elements, "
        "are noisier, and depend on the size of the elements"
        + (
            f"; `{tail}` is zero in {untouched} cases, in which most elements were not hit."
            if untouched
            else "."
        ),
        f"- **Beds.** {BEDS}",
        "- **Time step.** "
        + (
            f"On average over the angle of impact, a time step of {step:g} of the Rayleigh time "
            f"biases {bias}; at a single angle it may be three times as much."
            if bias
            else f"The bias of a time step of {step:g} of the Rayleigh time was not measured."
        ),
        "- **Failed cases.** "
        + (
            f"{len(said.failures)} cases gave no rate. They are not missing at random; "
            f"`failures.parquet` gives the reasons (most often: {for_markdown(reasons.index[0])})."
            if len(said.failures)
            else "None."
        ),
        "- **Physics.** Smooth dry spheres of one radius; a rigid flat plate whose shape is not "
        "changed by wear; wear proportional to Archard's constant, without effect on the motion; "
        "no fracture, plasticity or temperature. It is an open question which of the three wear "
        "measures applies to a metal; they differ.",
        "- **Ranges.** Quantities were drawn independently, so most rows do not describe a real "
        "material. Models trained on these data should not be used outside the ranges.",
        "- **The rates are simulated.** They were checked against closed forms, published tests "
        "and other codes, but not against wear measured in this arrangement.",
    ]


def _by_region(said: Description) -> Iterable[str]:
    """Where cases gave no rate, are flagged or noisy."""
    target = said.summary["target"]
    drawn = said.cases[list(SAMPLED_NAMES)].to_numpy(dtype=float)
    failed = said.cases["case_id"].isin(said.failures["case_id"]).to_numpy()
    good = said.dataset[list(SAMPLED_NAMES)].to_numpy(dtype=float)
    flagged = (said.dataset["quality"] != "ok").to_numpy()
    relative = pd.Series(relative_stderr(said.dataset, target))
    lines = [
        "### By region",
        "",
        f"Standard errors are those of `{target}`, relative to the rate; flags are those of the "
        "table above.",
        "",
        "| cases | drawn | no rate | flagged | standard error, median | 95th percentile |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for region in regions_of(drawn):
        among, held = region.holds(drawn), region.holds(good)
        errors = (percentage(relative[held].quantile(share), ".1f") for share in (0.5, 0.95))
        counts = map(str, (among.sum(), failed[among].sum(), flagged[held].sum()))
        lines.append(f"| {region.words} | {' | '.join([*counts, *errors])} |")
    return lines


def _floor(noise) -> str:
    if None in (noise["r2_floor"], *noise["r2_floor_band"]):
        return "These are too few to tell the largest R2 that a model of this column can reach."
    low, high = noise["r2_floor_band"]
    return (
        "They show that no model of this column can exceed "
        f"R2 = {score_number(noise['r2_floor'], 5)} ({score_range([low, high], 5)})."
    )


def _rights(said: Description) -> Iterable[str]:
    return [
        "## Licence and citation",
        "",
        f"[{LICENCE_NAME} ({LICENCE})]({LICENCE_URL}): free to use for any purpose with this "
        "citation:",
        "",
        f"> {for_markdown(said.reference)}" + (f" <{said.url}>" if said.url else ""),
        "",
        "```bibtex",
        said.bibtex,
        "```",
        "",
        "The software is licensed separately (MIT).",
    ]


def _number(value: float) -> str:
    return number_or_words(value, ".4g" if 1e-3 <= abs(value) < 1e5 else ".3g")


def _row(name: str, words: str, size: int) -> str:
    return f"| `{name}` | {words} | {size} |"


def _size(files: Iterable[File]) -> int:
    return sum(file.size for file in files)
