"""The configuration: its keys, their meaning, and the checks.

The declaration `Config` is the single source of the checks, the schema
(``workflow/schemas/config.schema.json``) and the documentation (``docs/config.md``);
``python -m abradem.config --write`` regenerates the latter two. Each problem of a configuration
is reported in one line, ``file: key: value: problem (allowed ...)``.

The package imports only pydantic and PyYAML, because the Snakefile imports it at every start, and
these only when they are used, because `abradem predict` needs the presets of materials alone.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from abradem.config.declaration import Config
    from abradem.config.geometry import geometry_ranges
    from abradem.config.keys import COMMAND_LINE
    from abradem.config.reading import (
        ConfigError,
        load_config,
        origin_in_files,
        read_config,
        refuse_all_but_data,
    )
    from abradem.config.reference import documentation, schema
    from abradem.config.values import (
        contacts_of,
        jet_is_known,
        rate_options,
        sampled_ranges,
        setup_dict,
        target_dict,
        to_yaml,
        typical_case,
    )

_LAZY = {
    "COMMAND_LINE": "keys",
    "Config": "declaration",
    "ConfigError": "reading",
    "documentation": "reference",
    "geometry_ranges": "geometry",
    "load_config": "reading",
    "origin_in_files": "reading",
    "read_config": "reading",
    "refuse_all_but_data": "reading",
    "rate_options": "values",
    "sampled_ranges": "values",
    "schema": "reference",
    "setup_dict": "values",
    "target_dict": "values",
    "contacts_of": "values",
    "jet_is_known": "values",
    "to_yaml": "values",
    "typical_case": "values",
}

__all__ = [
    "COMMAND_LINE",
    "Config",
    "ConfigError",
    "contacts_of",
    "documentation",
    "geometry_ranges",
    "jet_is_known",
    "load_config",
    "origin_in_files",
    "rate_options",
    "read_config",
    "refuse_all_but_data",
    "sampled_ranges",
    "schema",
    "setup_dict",
    "target_dict",
    "to_yaml",
    "typical_case",
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module(f"abradem.config.{_LAZY[name]}"), name)
    raise AttributeError(f"module 'abradem.config' has no attribute {name!r}")
