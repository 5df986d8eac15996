"""The published folder: contents agree with the descriptors, and public readers open it."""

import dataclasses
import hashlib
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.dataset
import pytest
from tables import product_law

from abradem.config import read_config, setup_dict
from abradem.dataset.join import DATASET_COLUMNS
from abradem.publish.folder import Study, publish, replacing_folder
from abradem.quantities import SAMPLED_NAMES, STDERR_COLUMNS, WEAR_COLUMNS
from abradem.store.columns import COLUMNS
from abradem.store.files import write_json
from abradem.store.tables import read_table, write_table
from abradem.words.escaping import for_bibtex, for_markdown, names_for_bibtex

ROOT = Path(__file__).parents[2]
BLOCKS, ROWS = 3, 4


def tables():
    """The tables of a study with three blocks of four cases, by path."""
    rows = product_law(BLOCKS * ROWS).assign(
        block=np.repeat(np.arange(BLOCKS), ROWS), seed=1, status="ok", quality="ok",
        steady_from=0.5, simulated_time=5.5, delivered_rate=4.0, face_share=1.0, wear_r2=1.0,
    )  # fmt: skip
    wear = rows["wear_total_mean"]
    rows = rows.assign(
        **dict.fromkeys(WEAR_COLUMNS, wear), **dict.fromkeys(STDERR_COLUMNS, 0.02 * wear)
    )
    rows = rows.assign(worn_volume_rate=wear, wear_per_kg=wear)
    failures = pd.DataFrame({"case_id": [99], "status": ["no wear"], "simulated_time": [1.0]})
    # The flattest plate of all gave no rate; the first two cases in number are flagged.
    lost = rows.iloc[[0]].assign(case_id=99, plate_angle=2.0)
    cases = pd.concat([rows, lost])[["case_id", "block", "seed", *SAMPLED_NAMES]]
    rows.loc[:1, "quality"] = "stderr"
    found = {"dataset": rows[list(DATASET_COLUMNS)], "failures": failures, "cases": cases}
    for block in range(BLOCKS):
        batch = rows[rows["block"] == block]
        runs = batch[["case_id", "block", "seed", "status", "simulated_time"]]
        found[f"runs/block-00{block}-batch-000"] = runs
        found[f"series/block-00{block}-batch-000"] = batch[["case_id"]].assign(time=0.0)
    return found


class Results:
    """The results of a study and its published folder."""

    def __init__(self, root):
        self.root, self.folder = root, root / "publish"
        config = read_config(ROOT / "config.yaml")
        said = {**config.publish.model_dump(), "date": "2026-01-31", "creators": ["Ada", "Bo"]}
        values = config.model_dump(mode="json")
        self.study = Study("tiny", values, setup_dict(config), said)
        self.files = []
        for name, table in tables().items():
            self.add(f"{name}.parquet", lambda path, table=table: write_table(table, path))
        noise = {"target": "wear_total_mean", "cases": 2, "replicates": 8, "r2_floor": 0.999,
                 "r2_floor_band": [0.998, 0.9995]}  # fmt: skip
        for name, value in {
            "learning/noise_floor.json": noise,
            "summary.json": {
                "flags": {"stderr": 1},
                "cases_without_flag": 11,
                "target": "wear_friction_p99",
                "target_words": "wear depth rate, friction, 99th percentile of 30 mm elements",
            },
            "versions.json": {
                "seed": 1,
                "code": {},
                "versions": {"abradem": "1", "numpy": "2"},
                "source": {"commit": "c0ffee", "changed": False},
            },
            "config.yaml": values,
        }.items():
            self.add(name, lambda path, value=value: write_json(value, path))

    def add(self, name, write):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write(path)
        self.files.append(path)

    def publish(self):
        publish(self.folder, self.root, self.files, self.study)

    def published(self):
        """Content of every file, by its path in the folder."""
        return {
            path.relative_to(self.folder).as_posix(): path.read_bytes()
            for path in self.folder.rglob("*")
            if path.is_file()
        }


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    results = Results(tmp_path_factory.mktemp("tiny"))
    results.publish()
    return results


def test_the_crate_lists_every_file_with_its_hash_and_size(made):
    described = json.loads(made.published()["ro-crate-metadata.json"])
    # The context of RO-Crate 1.1 does not define the term.
    assert described["@context"][1] == {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}
    graph = described["@graph"]
    listed = {entity["@id"]: entity for entity in graph if entity["@type"] == "File"}
    found = {k: v for k, v in made.published().items() if k != "ro-crate-metadata.json"}
    assert listed.keys() == found.keys()
    for name, content in found.items():
        assert listed[name]["sha256"] == hashlib.sha256(content).hexdigest()
        assert listed[name]["contentSize"] == str(len(content))
    entities = {entity["@id"]: entity for entity in graph}
    run = entities["#run"]
    assert run["object"] == {"@id": "config.yaml"}
    assert "code of commit c0ffee; " in run["description"]
    assert {"@id": "dataset.parquet"} in run["result"]
    assert {"@id": "README.md"} not in run["result"]
    assert entities["./"]["datePublished"] == "2026-01-31"
    assert entities["https://pypi.org/project/numpy/"]["softwareVersion"] == "2"


def test_the_same_results_give_the_same_bytes_and_nothing_else_is_left(made):
    before = made.published()
    made.publish()
    assert made.published() == before
    assert [path.name for path in made.root.iterdir() if path.name.startswith(".")] == []


def test_a_folder_that_is_not_complete_takes_no_place(tmp_path):
    (tmp_path / "publish").mkdir()
    (tmp_path / "publish" / "old").touch()
    with pytest.raises(KeyError), replacing_folder(tmp_path / "publish") as new:
        (new / "half").touch()
        raise KeyError
    assert [path.name for path in tmp_path.rglob("*")] == ["publish", "old"]


def test_the_card_names_every_column_range_licence_and_author(made):
    card = made.published()["README.md"].decode("utf-8")
    for name in DATASET_COLUMNS:
        assert f"| `{name}` | {COLUMNS[name].unit} |" in card
    for text in (
        "0.005 | 0.04 |",
        "CC-BY-4.0",
        "Ada, Bo (2026)",
        "12 of 13 sampled cases",
        "**Beds.**",
        "no wear",
    ):
        assert text in card
    assert "is below 0.2 or" in card and "0.99900" in card


def test_the_card_lists_the_limits_by_region(made):
    card = made.published()["README.md"].decode("utf-8")
    dataset = read_table(made.root / "dataset.parquet")
    lines = card[card.index("### By region") :].splitlines()
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in lines
        if line.startswith("| plate") or line.startswith("| radius") or line.startswith("| rele")
    ]
    found = {row[0]: row[1:] for row in rows}
    assert len(rows) == 8
    angles = [row for row in rows if row[0].startswith("plate")]
    drawn, lost, flagged = (sum(int(row[place]) for row in angles) for place in (1, 2, 3))
    assert (drawn, lost, flagged) == (BLOCKS * ROWS + 1, 1, 2)
    steep = dataset["plate_angle"] >= 50.0
    assert found["plate above 50 deg"] == [
        str(steep.sum()), "0", str((dataset["quality"][steep] != "ok").sum()), "2.0 %", "2.0 %"
    ]  # fmt: skip
    assert int(found["plate below 12 deg"][1]) == 1


def test_the_card_says_that_feed_may_be_lost(tmp_path):
    results = Results(tmp_path)
    losing = {**results.study.setup, "unplaced": "skip", "attempts": 3}
    results.study = dataclasses.replace(results.study, setup=losing)
    results.publish()
    card = results.published()["README.md"].decode("utf-8")
    assert "43 kg/s, less what finds no room at the factory (attempts: 3)" in card


@pytest.mark.parametrize(
    ("pair", "words"),
    [
        (None, "Contacts between spheres have the same coefficients as contacts with the plate."),
        (
            {"restitution": 0.35, "static_friction": 0.56, "rolling_friction": 0.05},
            "Contacts between spheres have a restitution of 0.35, a static friction of 0.56 and a "
            "rolling friction of 0.05.",
        ),
    ],
)
def test_the_card_says_how_spheres_meet(tmp_path, pair, words):
    results = Results(tmp_path)
    setup = {**results.study.setup, "pair_interaction": pair}
    results.study = dataclasses.replace(results.study, setup=setup)
    results.publish()
    assert words in results.published()["README.md"].decode("utf-8")


@pytest.mark.parametrize(
    "text",
    [
        "Wear by {DEM} & 50 % of $x_1$",
        "}} unbalanced { \\input{x}",
        "<script>alert(1)</script> [a](b) ![c](d)",
        "Rock and Roll Ltd.",
        "``` | cell | # heading",
    ],
)
def test_titles_and_names_are_text_in_every_file(tmp_path, text):
    results = Results(tmp_path)
    said = {**results.study.said, "title": text, "creators": [text, "Ada"], "url": "https://a.b/c"}
    results.study = dataclasses.replace(results.study, said=said)
    results.publish()
    files = results.published()
    crate = json.loads(files["ro-crate-metadata.json"])
    assert {"name": text, "@id": "#creator-1", "@type": "Person"} in crate["@graph"]
    croissant = json.loads(files["croissant.json"])
    assert croissant["alternateName"] == text
    card = files["README.md"].decode("utf-8").splitlines()
    assert card[0] == f"# {for_markdown(text)}"
    reference = f"{text}, Ada (2026). {text} (version 1.0.0) [data set]."
    assert f"> {for_markdown(reference)} <https://a.b/c>" in card
    start = card.index("```bibtex")
    entry = card[start + 1 : card.index("```", start)]
    assert entry == croissant["citeAs"].splitlines()
    assert f"  author = {{{names_for_bibtex([text, 'Ada'])}}}," in entry
    assert f"  title = {{{for_bibtex(text)}}}," in entry


def test_the_descriptor_gives_every_column_its_unit_and_source(made):
    described = json.loads(made.published()["croissant.json"])
    sets = {one["@id"]: one for one in described["recordSet"]}
    assert {"dataset", "failures", "dataset_by_block", "series_by_block"} <= sets.keys()
    fields = {field["name"]: field for field in sets["dataset"]["field"]}
    assert fields.keys() == set(DATASET_COLUMNS)
    assert fields["particle_radius"]["description"].endswith(", in m")
    assert fields["status"]["dataType"] == "sc:Text"


def test_the_descriptor_is_valid_and_loads(made):
    croissant = pytest.importorskip("mlcroissant", reason="pip install -e '.[publish]'")
    loaded = croissant.Dataset(jsonld=made.folder / "croissant.json")
    for name in ("dataset", "dataset_by_block"):
        assert len(list(loaded.records(name))) == BLOCKS * ROWS


def test_the_crate_is_read_back(made):
    rocrate = pytest.importorskip("rocrate.rocrate", reason="pip install -e '.[publish]'")
    crate = rocrate.ROCrate(made.folder)
    assert crate.get("dataset.parquet")["encodingFormat"] == "application/x-parquet"
    assert len(crate.data_entities) == len(made.published()) - 1


# Every reader gets the same rows and blocks from the parts as from the whole table.


def whole(made):
    return pd.read_parquet(made.folder / "dataset.parquet").sort_values("case_id")


def assert_whole(made, case_id, block):
    expected = whole(made)
    order = np.argsort(case_id)
    np.testing.assert_array_equal(np.asarray(case_id)[order], expected["case_id"])
    np.testing.assert_array_equal(np.asarray(block)[order].astype(int), expected["block"])


def test_pandas_reads_the_parts(made):
    found = pd.read_parquet(made.folder / "dataset")
    assert_whole(made, found["case_id"], found["block"])
    assert len(pd.read_parquet(made.folder / "series")) == BLOCKS * ROWS


def test_pyarrow_reads_the_parts(made):
    folder = made.folder / "dataset"
    found = pyarrow.dataset.dataset(folder, partitioning="hive").to_table()
    assert_whole(made, found["case_id"].to_numpy(), found["block"].to_numpy())
    assert found.schema.field("particle_radius").metadata[b"units"] == b"m"


def test_duckdb_reads_the_parts(made):
    duckdb = pytest.importorskip("duckdb", reason="pip install -e '.[publish]'")
    parts = f"read_parquet('{made.folder}/dataset/*/*.parquet', hive_partitioning = true)"
    found = duckdb.sql(f"select case_id, block from {parts}").fetchnumpy()
    assert_whole(made, found["case_id"], found["block"])


def test_polars_reads_the_parts(made):
    polars = pytest.importorskip("polars", reason="pip install -e '.[publish]'")
    parts = made.folder / "dataset" / "**" / "*.parquet"
    found = polars.scan_parquet(parts, hive_partitioning=True).collect()
    assert_whole(made, found["case_id"].to_numpy(), found["block"].to_numpy())
