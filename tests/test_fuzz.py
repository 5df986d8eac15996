"""Fuzz tests: mutated configurations and tables are refused with lines that name the place.

The mutations are drawn with a fixed seed; ABRADEM_FUZZ sets the number of each kind. An independent
JSON schema validator decides whether a mutated configuration is still valid.
"""

import contextlib
import datetime
import functools
import io
import math
import os
import pickle
from pathlib import Path

import jsonschema
import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from tables import product_law

from abradem.cli.main import main
from abradem.config import schema
from abradem.quantities import SAMPLED_NAMES, quantity
from abradem.store.tables import write_table

BASE = yaml.safe_load((Path(__file__).parents[1] / "config.yaml").read_text(encoding="utf-8"))
SCHEMA = jsonschema.Draft202012Validator(schema())
TABLE = product_law(24)[["case_id", *SAMPLED_NAMES, "wear_total_mean"]]

seeded = settings(
    max_examples=int(os.environ.get("ABRADEM_FUZZ", "30")),
    derandomize=True,
    database=None,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)
one_of = st.sampled_from


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory):
    with contextlib.chdir(tmp_path_factory.mktemp("fuzz")) as folder:
        yield folder


def refused(file):
    """Run the check with which `make run` begins; its lines are about ``file``."""
    before = {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        code = main(["config", "--folder", "config.yaml"])
    lines = said.getvalue().splitlines()
    assert code == 2
    assert lines and all(line.startswith(f"{file}: ") for line in lines)
    assert max(map(len, lines)) < 2000
    assert before == {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}
    return lines


# Configurations


def leaves(value, above=()):
    """Paths of all values that are not sections."""
    if isinstance(value, dict) and value:
        for name, inner in value.items():
            yield from leaves(inner, (*above, name))
    else:
        yield above


def at(document, path):
    return functools.reduce(lambda inner, part: inner[part], path, document)


def put(path, value, document=BASE):
    """The document with one value replaced."""
    if not path:
        return value
    return {**document, path[0]: put(path[1:], value, document[path[0]] if path[1:] else None)}


def text(document):
    return yaml.safe_dump(document, sort_keys=False).encode()


LEAVES = list(leaves(BASE))
SECTIONS = sorted({path[:-1] for path in LEAVES})
RANGES = [path for path in LEAVES if path[:2] == ("sampling", "ranges")]
NUMBERS = [path for path in LEAVES if type(at(BASE, path)) in (int, float)]


@st.composite
def wrong_types(draw):
    other = draw(
        one_of(["word", "", [], {}, True, None, [[1]], {"a": 1}, datetime.date(2024, 1, 1)])
    )
    document = put(draw(one_of(LEAVES)), other)
    assume(not SCHEMA.is_valid(document))
    return text(document)


@st.composite
def slips_of_units(draw):
    path = draw(one_of([*NUMBERS, *RANGES]))
    factor = draw(one_of([1e3, 1e9, 1e-3, 1e-9, -1.0, -1e3, 1e300]))
    value = at(BASE, path)
    slipped = [factor * one for one in value] if isinstance(value, list) else factor * value
    document = put(path, slipped)
    assume(not SCHEMA.is_valid(document))
    return text(document)


@st.composite
def no_finite_numbers(draw):
    path = draw(one_of([*NUMBERS, *RANGES]))
    odd = draw(one_of([math.nan, math.inf, -math.inf, 10**400]))
    value = at(BASE, path)
    if isinstance(value, list):
        odd = draw(one_of([[odd, value[1]], [value[0], odd], [odd, odd]]))
    return text(put(path, odd))


@st.composite
def numbers_that_yaml_turns_into_others(draw):
    """In the text of the file, as a writer of YAML would put such a word in quotes."""
    path = draw(one_of(NUMBERS))
    word = draw(one_of(["0%o", "0x%x", "0b1%d", "%d_0", "%d:30", "0o%o", "yes", "1%d-01-01"]))
    number = draw(st.integers(1, 7))
    return text(put(path, "@word@")).replace(
        b"'@word@'", (word % number if "%" in word else word).encode()
    )


@st.composite
def swapped_bounds(draw):
    path = draw(one_of(RANGES))
    return text(put(path, at(BASE, path)[::-1]))


@st.composite
def odd_keys(draw):
    section = draw(one_of(SECTIONS))
    name = draw(one_of(list(at(BASE, section))))
    odd = draw(one_of([name[:-1], name + "s", name.upper(), f" {name}", "__use_yte__", "?x", "ñ"]))
    assume(odd not in at(BASE, section))
    return text(put((*section, odd), at(BASE, (*section, name))))


@st.composite
def keys_given_twice(draw):
    lines = text(BASE).splitlines(keepends=True)
    first = draw(
        one_of([n for n, line in enumerate(lines) if line.strip()[-1:] != b":" and b": " in line])
    )
    return b"".join([*lines[: first + 1], *lines[first:]])


@st.composite
def names_that_leave_the_folder(draw):
    parts = draw(
        st.lists(
            one_of(["..", ".", "/", "~", "a", "%2e", "\\", "\0", " ", "$HOME", "\n"]),
            min_size=1,
            max_size=5,
        )
    )
    assume(not all(part == "a" for part in parts))
    return yaml.safe_dump({**BASE, "study": "".join(parts)}).encode()


@st.composite
def tags_and_anchors(draw):
    path = draw(one_of(LEAVES))
    marked = text(put(path, "MARK"))
    tag = draw(one_of([
        b"!!python/object/apply:os.system ['touch pwned']", b"!!python/name:os.system", b"!x y",
        b"!!python/object/new:os.system [touch pwned]", b"!!binary gA==", b"*nothing",
        b"&a [*a]", b"&a {b: *a}", b"!!set {a, b}", b"!!timestamp 2024-99-99",
        b"&a [" + b",".join([b"&b [1, 2]"] * 3 + [b"*b"] * 30_000) + b"]",
    ]))  # fmt: skip
    return marked.replace(b"MARK", tag)


@st.composite
def broken_text(draw):
    content = text(BASE)
    place = draw(st.integers(0, len(content) - 1))
    odd = draw(one_of([b"\xff", b"\xc3\x28", b"\0", b"\x07", b"\x1b[2K", b"\xed\xa0\x80"]))
    return content[:place] + odd + content[place:]


@st.composite
def no_configuration_at_all(draw):
    return draw(one_of([
        b"", b" \n", b"# words\n", b"---\n", b"...\n", b"null\n", b"1\n", b"[]\n", b"- a\n",
        b"{}\n", b"\xff\xfes\0t\0", b"PK\x03\x04", pickle.dumps({"study": "a"}), b"PAR1",
        b"a: 1\n---\nb: 2\n",
        b"[" * 20_000, b"a:\n" * 1000, b"{" * 3000, b"\t", b"%YAML 9.9\n---\na: 1\n", b"study\n",
    ]))  # fmt: skip


@st.composite
def more_than_there_is_room_for(draw):
    return text(draw(one_of([
        put(("sampling", "blocks"), 10**12),
        put(("sampling", "cases_per_block"), 10**9),
        {**BASE, "sampling": {"blocks": 10_000, "cases_per_block": 100_000}},
        {**BASE, "sampling": {"blocks": 10_000, "cases_per_block": 100}},
        put(("simulation", "plate", "facet_size_mm"), 1e-6),
        put(("simulation", "stop", "sample_interval_s"), 1e-9),
        put(("simulation", "time_step_rayleigh_fraction"), 1e-12),
        put(("learning", "repeats"), 10**9),
        put(("learning", "ga_ann", "population"), 10**9),
    ])))  # fmt: skip


CONFIGURATIONS = st.one_of(
    wrong_types(), slips_of_units(), no_finite_numbers(), numbers_that_yaml_turns_into_others(),
    swapped_bounds(), odd_keys(),
    keys_given_twice(), names_that_leave_the_folder(), tags_and_anchors(), broken_text(),
    no_configuration_at_all(), more_than_there_is_room_for(),
)  # fmt: skip


@seeded
@given(CONFIGURATIONS)
def test_a_mutated_configuration_is_refused(content):
    Path("config.yaml").write_bytes(content)
    refused("config.yaml")


# Tables


@st.composite
def tables_with_odd_values(draw):
    """An impossible column, or a column with an impossible value."""
    name = draw(one_of([*SAMPLED_NAMES, "wear_total_mean"]))
    odd = draw(
        one_of(
            [
                math.nan,
                math.inf,
                -math.inf,
                "",
                "word",
                "1,5",
                "1 000",
                "0x10",
                "-",
                "1e999",
                "nan",
                "None",
                "TRUE",
            ]
        )
    )
    rows = draw(one_of([[3], [0, 23], list(range(24))]))
    values = TABLE[name].astype(object)
    values.iloc[rows] = odd
    return TABLE.assign(**{name: values}), ".csv"


@st.composite
def tables_with_slipped_units(draw):
    name = draw(one_of([*SAMPLED_NAMES, "wear_total_mean"]))
    factor = draw(one_of([1e3, 1e9, 1e-9, -1.0, -1e9]))
    values = factor * TABLE[name]
    if name == "wear_total_mean":
        assume(factor < 0)
    else:
        low, high = quantity(name).limits
        assume(((values < low) | (values > high)).any())
    return TABLE.assign(**{name: values}), draw(one_of([".csv", ".parquet"]))


@st.composite
def tables_with_odd_columns(draw):
    name, other = draw(st.permutations([*SAMPLED_NAMES, "wear_total_mean"]))[:2]
    kind = draw(one_of(["missing", "twice", "swapped", "renamed"]))
    if kind == "missing":
        return TABLE.drop(columns=name), ".csv"
    if kind == "twice":
        return pd.concat([TABLE, TABLE[[name]]], axis=1), ".csv"
    if kind == "renamed":
        return TABLE.rename(columns={name: f"{name} "[::-1]}), ".csv"
    swapped = TABLE.rename(columns={name: other, other: name})
    limits = {column: quantity(column).limits for column in SAMPLED_NAMES}
    assume(any(
        ((swapped[column] < low) | (swapped[column] > high)).any()
        for column, (low, high) in limits.items()
    ) or (swapped["wear_total_mean"] <= 0.0).any())  # fmt: skip
    return swapped, ".csv"


@st.composite
def tables_with_odd_keys(draw):
    keys = draw(one_of([
        [0] * 24, [0.5, *range(1, 24)], [*range(23), 0], ["a"] * 24, [math.nan, *range(1, 24)],
        [10**30, *range(1, 24)], [-(10**30), *range(1, 24)],
    ]))  # fmt: skip
    return TABLE.assign(case_id=keys), ".csv"


@st.composite
def parquet_of_odd_types(draw):
    name = draw(one_of([*SAMPLED_NAMES, "wear_total_mean"]))
    odd = draw(one_of([
        [[1.0, 2.0]] * 24, [{"a": 1}] * 24, [datetime.datetime(2024, 1, 1)] * 24, [b"\xff"] * 24,
        [True] * 24, [None] * 24, ["a"] * 24, [datetime.timedelta(1)] * 24, [1 + 2j] * 24,
    ]))  # fmt: skip
    assume(not isinstance(odd[0], complex))
    return TABLE.assign(**{name: pd.Series(odd)}), ".parquet"


@st.composite
def files_that_are_no_table(draw):
    suffix = draw(one_of([".csv", ".parquet", ".txt", ".xlsx", ""]))
    content = draw(one_of([
        b"", b"\n", b"\n\n\n", b",", b"a,b\n1\n", b"\xff\xfe", b"PAR1", b"PAR1PAR1", b"\0" * 100,
        b'"', b'a,"b\n' * 10, pickle.dumps(TABLE), b"<html></html>", b"{}", b"a;b\n1;2\n",
        TABLE.to_csv(index=False).splitlines()[0].encode(),
        TABLE.to_csv(index=False).encode("utf-16"),
        TABLE.to_csv(index=False).encode() + b"1,2\n", b"1," + TABLE.to_csv(index=False).encode(),
        TABLE.to_csv(index=False).replace(",", ";").encode(),
        TABLE.rename(columns={"restitution": "Stoßzahl"}).to_csv(index=False).encode("latin-1"),
    ]))  # fmt: skip
    return content, suffix


@st.composite
def damaged_parquet(draw):
    write_table(TABLE, "whole.parquet")
    content = Path("whole.parquet").read_bytes()
    Path("whole.parquet").unlink()
    place = draw(st.integers(0, len(content) - 1))
    if draw(st.booleans()):
        return content[:place], ".parquet"
    flipped = bytearray(content)
    flipped[place] ^= draw(st.integers(1, 255))
    return bytes(flipped), ".parquet"


def stored(table, suffix):
    """Any table, named t."""
    path = Path(f"t{suffix}")
    if isinstance(table, bytes):
        path.write_bytes(table)
    elif suffix == ".csv":
        table.to_csv(path, index=False)
    else:
        table.to_parquet(path)
    return path


def check_stored(table, suffix):
    path = stored(table, suffix)
    Path("config.yaml").write_bytes(text({"study": "a", "dataset": {"external": str(path)}}))
    try:
        return refused(path)
    finally:
        path.unlink()


@seeded
@given(st.one_of(
    tables_with_odd_values(), tables_with_slipped_units(), tables_with_odd_columns(),
    tables_with_odd_keys(), parquet_of_odd_types(), files_that_are_no_table(),
))  # fmt: skip
def test_a_mutated_table_is_refused(table):
    check_stored(*table)


@seeded
@given(damaged_parquet())
def test_a_damaged_parquet_file_is_refused_or_holds_the_same_numbers(table):
    """A flipped bit in unused data does no harm; every number is protected by a checksum."""
    path = stored(*table)
    Path("config.yaml").write_bytes(text({"study": "a", "dataset": {"external": str(path)}}))
    with (
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()) as said,
    ):
        code = main(["config", "--folder", "config.yaml"])
    if code == 2:
        assert all(line.startswith(f"{path}: ") for line in said.getvalue().splitlines())
    else:
        from abradem.dataset.external import read_external

        found = read_external(path)
        np.testing.assert_array_equal(found[list(TABLE)], TABLE)
    path.unlink()
