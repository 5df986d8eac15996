"""What would stop a run at its end, found before its first job.

Each function returns one line for each problem, with the key of the configuration, the value and
what is allowed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from abradem.config import geometry_ranges, sampled_ranges, setup_dict, typical_case

if TYPE_CHECKING:
    import pandas as pd

    from abradem.config import Config

PICTURES = {"scene", "angles"}
"""Rules that simulate the typical case."""

_LOOKED_AT = 50_000
_SURFACES_LOOKED_AT = 200
"""Largest number of cases that are drawn and checked before a run, which takes seconds; with a
geometry each has a surface of its own."""


def problems_at_start(
    config: Config, rules: Collection[str], learns: bool, cases: Iterable[int] = ()
) -> list[str]:
    """Return the problems of a run with simulations.

    Parameters
    ----------
    config : Config
    rules : collection of str
        Rules with jobs to run.
    learns : bool
        Whether models are among them.
    cases : iterable of int
        Single cases that are asked for.
    """
    problems = [
        f"case {case}: there is no such case (allowed 0 ... {config.cases - 1})"
        for case in sorted(set(cases))
        if case >= config.cases
    ]
    if learns:
        problems += too_few_rows(config, config.cases, "sampling.blocks and cases_per_block: ")
    if "simulate" in rules and "dataset" in rules:
        problems += _too_many_rejected(config)
    if PICTURES & set(rules):
        problems += _impossible_pictures(config)
    return problems


def problems_of_table(config: Config, table: pd.DataFrame) -> list[str]:
    """Return the problems of a study on an external table, from `read_external`."""
    where, target = config.dataset.external, config.learning.target
    problems = too_few_rows(config, len(table), f"{where}: ")
    if target not in table:
        known = ", ".join(name for name in table.columns if name.startswith("wear_"))
        problems.append(f"{where}: lacks {target}, the learning.target (the table has {known})")
    elif not (table[target] > 0.0).any():
        problems.append(f"{where}: {target} is nowhere positive, there is nothing to learn")
    return problems


def too_few_rows(config: Config, rows: int, where: str) -> list[str]:
    """Return whether a number of rows is too small for the models or the splits."""
    from abradem.learning.protocols import held_out, most_held_out
    from abradem.learning.rows import FEWEST_ROWS, FEWEST_TRAINED

    if rows < FEWEST_ROWS:
        return [f"{where}{rows} rows are too few to learn from (allowed from {FEWEST_ROWS})"]
    share = config.learning.test_share
    most = most_held_out(rows, FEWEST_TRAINED)
    if share > most:
        return [
            f"learning.test_share: {share:g}: leaves fewer than {FEWEST_TRAINED} of {rows} rows to "
            f"learn from (allowed up to {most:.2g})"
        ]
    trained, part = rows - held_out(rows, share), config.learning.ga_ann.validation_share
    most = most_held_out(trained, 1)
    if part > most:
        return [
            f"learning.ga_ann.validation_share: {part:g}: leaves none of {trained} training rows "
            f"to learn from (allowed up to {most:.2g})"
        ]
    return []


def no_graphics_card(config: Config) -> list[str]:
    """Return whether networks shall be trained on a device that this machine lacks."""
    if config.learning.ga_ann.device == "cuda":
        import torch

        if not torch.cuda.is_available():
            return ["learning.ga_ann.device: cuda: torch finds no graphics card (allowed cpu)"]
    return []


def _too_many_rejected(config: Config) -> list[str]:
    """Return whether more sets are physically inconsistent than cases may fail."""
    import pandas as pd

    from abradem.dem.model import Setup
    from abradem.sampling.draw import block_cases

    setup, ranges = Setup.from_dict(setup_dict(config)), sampled_ranges(config)
    sampling, geometry = config.sampling, geometry_ranges(config)
    if config.cases > (_LOOKED_AT if setup.geometry is None else _SURFACES_LOOKED_AT):
        return []
    drawn = [
        block_cases(
            config.seed, block, sampling.cases_per_block, sampling.method, ranges, setup, geometry
        )
        for block in range(sampling.blocks)
    ]
    reasons = pd.concat([cases["rejected"] for cases in drawn])
    reasons = reasons[reasons != ""]
    share = config.simulation.max_failed_share
    if len(reasons) > share * config.cases or len(reasons) == config.cases:
        return [
            f"sampling.ranges: {len(reasons)} of {config.cases} cases are inconsistent, such as: "
            f"{reasons.iloc[0]} (allowed {min(share, 1.0):.0%}, simulation.max_failed_share)"
        ]
    return []


def _impossible_pictures(config: Config) -> list[str]:
    """Return the typical cases of the figures and of the film that cannot be simulated."""
    from abradem.dem.model import Setup
    from abradem.sampling.checks import check_case

    typical, setup = typical_case(config), Setup.from_dict(setup_dict(config))
    angles, film = config.figures.angles, config.figures.movie
    varied: list[tuple[str, Mapping[str, Any]]] = [("figures.typical", {})]
    if setup.geometry is None:
        varied += [
            *(("figures.angles.plate", {"plate_angle": angle}) for angle in angles.plate),
            *(("figures.angles.factory", {"factory_angle": angle}) for angle in angles.factory),
            *(
                ("figures.movie.plate_angles", {"plate_angle": angle})
                for angle in film.plate_angles
            ),
        ]
    found: dict[str, str] = {}
    for key, change in varied:
        if reason := check_case({**typical, **change}, setup):
            shown = "".join(f": {value:g}" for value in change.values())
            found.setdefault(key, f"{key}{shown}: cannot be simulated: {reason}")
            if not change:
                # The angles are those of the same case.
                break
    return list(found.values())
