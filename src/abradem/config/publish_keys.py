"""Keys of `publish`."""

from __future__ import annotations

import datetime
import re
from typing import Annotated

from pydantic import AfterValidator, Field, WithJsonSchema

from abradem.config.fields import Section, Text, setting

_URL = r"^https://[A-Za-z0-9._~:/?#\[\]@!$&'()*+,;=%-]+$"

"""An address in the characters of RFC 3986; others are written as %XX."""

_DAY = r"^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])$"


def _check_day(value: str) -> str:
    if not re.fullmatch(_DAY, value):
        raise ValueError("has the wrong form")
    try:
        datetime.date.fromisoformat(value)
    except ValueError:
        raise ValueError("there is no such day") from None
    return value


Day = Annotated[
    str, AfterValidator(_check_day), WithJsonSchema({"type": "string", "pattern": _DAY})
]


class Publish(Section):
    """Metadata that `snakemake publish` adds to the data set."""

    title: Text | None = setting(
        None, "Title; null: derived from the name of the study.", allowed="null or text"
    )
    creators: Annotated[list[Text], Field(min_length=1)] = setting(
        ["abradem developers"], "Creators of the data set.", allowed="a list of names"
    )
    version: str = setting(
        "1.0.0",
        "Version of the data set.",
        allowed="1.0.0, 1.0.1, 2.0.0 ...",
        pattern=r"^[0-9]{1,6}\.[0-9]{1,6}\.[0-9]{1,6}$",
    )
    date: Day | None = setting(
        None,
        "Date of publication; null: the date on which the data set was written.",
        allowed='null or a date in quotes, "2026-01-31"',
    )
    url: str | None = setting(
        None,
        "Address of the published data set, such as https://doi.org/...",
        allowed="null or an address that begins with https://",
        pattern=_URL,
    )
    series: bool = setting(
        True,
        "Whether to include the series, maps and runs of every case, which are larger than the "
        "data set.",
        allowed="true or false",
    )
