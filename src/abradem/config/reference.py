"""Schema and documentation, generated from the declaration: python -m abradem.config --write."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from pydantic.fields import FieldInfo

from abradem.config.declaration import Config
from abradem.config.explaining import allowed_text, section_class
from abradem.config.fields import Section, number_text
from abradem.config.keys import Key, dotted, show
from abradem.config.quantity_texts import with_texts

SCHEMA_FILE = "workflow/schemas/config.schema.json"
DOCUMENTATION_FILE = "docs/config.md"


def schema() -> dict:
    """Return the JSON schema (draft 2020-12) of the configuration."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **with_texts(Config.model_json_schema()),
    }


def documentation() -> str:
    """Return the reference of all keys as Markdown."""
    lines = [
        "# Configuration",
        "",
        "Generated from `src/abradem/config/` by `python -m abradem.config --write`.",
        "",
        "`config.yaml` is the study of the paper. Another study is an override file, such as",
        "`studies/smoke.yaml`, with only the keys that differ. A key that is not given has the",
        "default below. Values are in SI units unless the key names another unit; a value may name",
        "its own, such as `2 cm`, `45°` or `18 km/h`.",
        "",
        *_document_section(Config, ()),
    ]
    return "\n".join(lines)


def _document_section(section: type[Section], above: Key) -> list[str]:
    lines = []
    if above:
        doc = " ".join((section.__doc__ or "").split())
        lines += [f"## {dotted(above)}", "", doc, ""]
    values = [
        (name, field)
        for name, field in section.model_fields.items()
        if section_class(field.annotation) is None or field.default is None
    ]
    if values:
        lines += ["| key | default | allowed | meaning |", "| --- | --- | --- | --- |"]
        for name, field in values:
            default = "required" if field.is_required() else f"`{_default(field)}`"
            lines.append(f"| `{name}` | {default} | {allowed_text(field)} | {field.description} |")
        lines.append("")
    for name, field in section.model_fields.items():
        inner = section_class(field.annotation)
        if inner is not None:
            lines += _document_section(inner, (*above, name))
    return lines


def _default(field: FieldInfo) -> str:
    if isinstance(field.default, tuple):
        return f"[{number_text(field.default[0])}, {number_text(field.default[1])}]"
    if isinstance(field.default, float):
        return number_text(field.default)
    return field.default if isinstance(field.default, str) else show(field.default)


def generated(root: Path) -> dict[Path, str]:
    """Return the files that are generated from the declaration, with their text."""
    return {
        root / SCHEMA_FILE: json.dumps(schema(), indent=2) + "\n",
        root / DOCUMENTATION_FILE: documentation(),
    }


def main(arguments: Sequence[str]) -> int:
    """Write the generated files below the current folder."""
    if Config.__doc__ is None:
        print("python -m abradem.config: needs docstrings, run it without -OO or PYTHONOPTIMIZE")
        return 2
    # Not needed where the configuration is read, at every start of the workflow.
    from abradem.store.files import write_text

    if list(arguments) != ["--write"]:
        print(f"usage: python -m abradem.config --write  ({SCHEMA_FILE}, {DOCUMENTATION_FILE})")
        return 2
    for path, text in generated(Path.cwd()).items():
        write_text(text, path)
    return 0
