"""Tables of the user and the search for what explains them, checked before anything is written.

The workflow and `abradem config` ask the same functions, so that one refuses what the other does.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import NamedTuple

from abradem.config import Config, ConfigError, origin_in_files
from abradem.dataset.external import read_external, repeated
from abradem.dataset.user_table import local_file
from abradem.dataset.variation import nothing_varies
from abradem.quantities import SAMPLED_NAMES
from abradem.running.readiness import problems_of_table
from abradem.running.trial_setups import drawn_setups
from abradem.store.files import TableError


class CalibrationInputs(NamedTuple):
    """What a calibration begins with.

    Attributes
    ----------
    table : str
        Path of the table.
    trials, setups : list of dict
        Values and plain set-ups of all trials.
    """

    table: str
    trials: list[dict]
    setups: list[dict]


class ExternalInput(NamedTuple):
    """A table that is learned from.

    Attributes
    ----------
    table : str
        Path of the table.
    repeated : str
        Line on rows that repeat others, or "".
    nothing_varies : str
        Why nothing can be learned, or "".
    """

    table: str
    repeated: str
    nothing_varies: str


def calibration_inputs(
    config: Config, files: Sequence[str | os.PathLike] = (), command_line: Sequence[str] = ()
) -> CalibrationInputs:
    """Return what a calibration begins with.

    Parameters
    ----------
    config : Config
    files, command_line : sequence
        What the configuration was read from, for the lines.

    Raises
    ------
    ConfigError, TableError
        If the table or the search cannot be, with all problems.
    """
    search = config.calibration
    problems: list[str] = []
    path = ""
    trials: list[dict] = []
    setups: list[dict] = []
    try:
        path = _table("calibration.table", search.table)
        table = read_external(path, search.columns)
        if search.target not in table:
            problems.append(f"{path}: lacks {search.target}, the calibration.target")
        unknown = sorted(set(search.leave_out) - set(table["case_id"]))
        if unknown:
            problems.append(
                f"{path}: has no row {', '.join(map(str, unknown[:5]))} of calibration.leave_out"
            )
    except TableError as error:
        problems += str(error).splitlines()
    try:
        trials, setups = drawn_setups(config)
    except ConfigError as error:
        origin = origin_in_files(("calibration", "search"), files, command_line)
        problems += [f"{origin}: {line}" if origin else line for line in error.problems]
    if problems:
        raise ConfigError(problems)
    return CalibrationInputs(path, trials, setups)


def external_input(config: Config) -> ExternalInput:
    """Return what is known of the table of ``dataset.external``.

    Raises
    ------
    TableError
        If it cannot be used, with one line for each problem.
    """
    path = _table("dataset.external", config.dataset.external)
    table = read_external(path, config.dataset.columns)
    if problems := problems_of_table(config, table):
        raise TableError("\n".join(problems))
    fixed = nothing_varies(table[list(SAMPLED_NAMES)].to_dict("list"))
    why = (
        f"dataset.external: {path}: every quantity has the same value in all rows, so nothing can "
        "be learned (allowed: at least one that varies)"
    )
    return ExternalInput(path, repeated(table), why if fixed else "")


def _table(key: str, given: str | None) -> str:
    """Path of the table of a key; raises if there is no such file."""
    try:
        return str(local_file(given or ""))
    except TableError as error:
        raise TableError(f"{key}: {error}") from None
