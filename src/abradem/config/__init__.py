"""The configuration: what may stand in it, what each key means, and what is wrong with one.

One declaration, `Config`, is the source of the check, of the schema
(``workflow/schemas/config.schema.json``) and of the documentation (``docs/config.md``);
``python -m abradem.config --write`` regenerates both. Every problem of a configuration is
reported as one line ``file: key: value: what is wrong (allowed ...)``.

The module is light (pydantic and PyYAML), as the Snakefile imports it on every start.
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
