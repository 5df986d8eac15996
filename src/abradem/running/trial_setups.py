"""Set-ups of a calibration from its configuration, and the best one as an override file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml

from abradem.calibration.agreement import SCORES
from abradem.calibration.halving import Rung, rungs
from abradem.calibration.space import Unknown, draw, keys_of, unknowns
from abradem.config import Config, ConfigError, load_config, setup_dict
from abradem.learning.number_text import score_number


def search_space(config: Config) -> list[Unknown]:
    """Return the unknowns of the search.

    Raises
    ------
    ConfigError
        If the search space is empty or not one.
    """
    try:
        space = unknowns(config.calibration.search)
    except ValueError as error:
        raise ConfigError([f"calibration.search: {error}"]) from None
    if not space:
        raise ConfigError(["calibration.search: is empty; name at least one unknown key"])
    return space


def search_rungs(config: Config) -> list[Rung]:
    """Return the rungs of the search."""
    given = config.calibration
    return rungs(given.trials, given.keep, given.rows, given.replicates)


def drawn_setups(config: Config) -> tuple[list[dict], list[dict]]:
    """Return the values and the plain set-ups of all trials.

    Raises
    ------
    ConfigError
        If a value is not allowed for its key, or in conflict with others.
    """
    space = search_space(config)
    trials = draw(space, config.calibration.trials, config.seed)
    problems: dict[str, None] = {}
    setups = []
    for values in trials:
        try:
            setups.append(setup_dict(with_values(config, values)))
        except ConfigError as error:
            problems |= dict.fromkeys(line.removeprefix("a set-up: ") for line in error.problems)
    if problems:
        raise ConfigError([f"calibration.search: {line}" for line in problems])
    return trials, setups


def with_values(config: Config, values: Mapping[str, object]) -> Config:
    """Return the configuration with the values of a trial."""
    merged = config.model_dump(mode="json")
    for key, value in keys_of(values).items():
        *path, name = key.split(".")
        section = merged
        for part in path:
            if not isinstance(section.get(part), dict):
                # Unknown keys are refused with the others, and null becomes a section.
                section[part] = {}
            section = section[part]
        section[name] = value
    return load_config(merged, "a set-up")


def override_file(resolved: Mapping, outcome: Mapping) -> str:
    """Return a study with the best set-up, as the text of an override file.

    Parameters
    ----------
    resolved : mapping
        Resolved configuration of the calibration, as plain values.
    outcome : mapping
        From `abradem.calibration.outcome.outcome`.
    """
    config = load_config(resolved)
    made = with_values(config, outcome["values"]).model_dump(mode="json")
    size = outcome["element_size"]
    study: dict[str, Any] = {
        "study": f"{config.study}_best"[:64],
        "simulation": made["simulation"],
        "wear_rate": {"element_size_mm": None if size is None else round(1e3 * size, 9)},
        "learning": {"target": f"wear_{outcome['measure']}_{outcome['statistic']}"},
        "calibration": {"table": None},
    }
    said = {name: score_number(value, 3) for name, value in outcome["scores"]["both"].items()
            if name in SCORES}  # fmt: skip
    head = (
        f"# The set-up that explains {config.calibration.table} best, trial {outcome['trial']} of\n"
        f"# study {config.study}: R2 of ln y {said['log_r2']}, of y {said['r2']}, constant "
        f"{said['constant']}.\n"
    )
    text = yaml.safe_dump(study, sort_keys=False, default_flow_style=None, width=100)
    return head + text
