"""The configuration: its keys, their meaning, and the checks.

The declaration `Config` is the single source of the checks, the schema
(``workflow/schemas/config.schema.json``) and the documentation (``docs/config.md``);
``python -m abradem.config --write`` regenerates the latter two. Each problem of a configuration
is reported in one line, ``file: key: value: problem (allowed ...)``.

The package imports only pydantic and PyYAML, because the Snakefile imports it at every start.
"""

from abradem.config.declaration import Config
from abradem.config.keys import COMMAND_LINE
from abradem.config.reading import ConfigError, load_config, read_config, refuse_all_but_data
from abradem.config.reference import documentation, schema
from abradem.config.values import sampled_ranges, setup_dict, to_yaml, typical_case

__all__ = [
    "COMMAND_LINE",
    "Config",
    "ConfigError",
    "documentation",
    "load_config",
    "read_config",
    "refuse_all_but_data",
    "sampled_ranges",
    "schema",
    "setup_dict",
    "to_yaml",
    "typical_case",
]
