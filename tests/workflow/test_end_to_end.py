"""The smoke study from configuration to report, and the jobs that rerun after each change.

A copy of the project is run once. Most tests then change something, count the jobs of a dry run,
and undo the change.
"""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest
import yaml
from browser import ROOMS, opened, show, wait_for
from latex_checks import assert_agree, at_source, is_number, macros, rows
from loaded_snakemake import loaded_snakemake
from tables import product_law

from abradem.dem.cache import cache_folder
from abradem.dem.warm import warm
from abradem.figures.catalogue import CALIBRATION, SURFACE
from abradem.figures.catalogue import FIGURES as CATALOGUE
from abradem.quantities import SAMPLED_NAMES
from abradem.report import latex
from abradem.store.checksums import recorded
from abradem.store.tables import read_result, read_table

ROOT = Path(__file__).parents[2]
SMOKE = "studies/smoke.yaml"
GROWN = (SMOKE, "studies/smoke_grown.yaml")
BLOCKS, BATCHES_PER_BLOCK = 2, 2
BATCHES = BLOCKS * BATCHES_PER_BLOCK


def each(*rules):
    """One job of each rule."""
    return dict.fromkeys(rules, 1)


OF_LINEAR = each("figure_coefficients", "figure_residuals", "figure_predicted_linear")
OF_PCA = each("figure_correlations", "figure_loadings", "figure_components")
OF_TREES = each("figure_tree", "figure_tree_depth")
OF_GA_ANN = each("figure_ga_ann", "figure_architecture")
# The overview shows the figure of the comparison.
OF_COMPARISON = each("figure_comparison", "figure_predictions", "overview")
OF_PHYSICAL = each("figure_models", "figure_power_law", "figure_sensitivity", "figure_reach")
OF_LEARNING = {
    **OF_LINEAR, **OF_PCA, **OF_TREES, **OF_GA_ANN, **OF_COMPARISON, **OF_PHYSICAL,
    **each("figure_penalised", "figure_selection", "figure_distributions"),
}  # fmt: skip
OF_SIMULATIONS = each("figure_series", "figure_maps", "figure_gallery")
OF_CHARTS = each("figure_generation", "figure_rules")
SCENES = each("scene", "scene_page", "angles", "figure_setup", "figure_angles")
FIGURES = {
    **OF_SIMULATIONS, **OF_CHARTS, **each("figure_quality", "figure_setup", "figure_angles"),
    **OF_LEARNING,
}  # fmt: skip
# The tables of scores, comparison, beside_paper and error_by_region follow every model.
AFTER_SCORES = {
    **each("scores", "figure_models", "figure_distributions", "summary", "latex", "findings"),
    **OF_COMPARISON, "table": 4,
}  # fmt: skip
PHYSICAL = each(
    "fit_physical", "intervals", "local_wear", "surrogate", "sensitivity", "reach", "findings",
)  # fmt: skip
TRAINING = {
    **each("linear", "penalised", "pca", "selection", "trees"), "ga_ann": 2, **PHYSICAL,
}  # fmt: skip
LEARNING = {
    **TRAINING, **OF_LEARNING,
    **each("scores", "exponents", "summary", "latex", "model_card", "explorer"), "table": 15,
}  # fmt: skip
AFTER_DATASET = {
    **LEARNING, **each("figure_quality", "noise_floor", "speed_up", "wear_maps", "all"),
    "table": 17,
}  # fmt: skip
AFTER_WEAR_RATES = {**each("failures", "dataset"), **AFTER_DATASET}
AFTER_SIMULATION = {"wear_rates": BATCHES, **AFTER_WEAR_RATES, **OF_SIMULATIONS}
# Rules affected by ranges and code of the simulations; the rule graph depends on the workflow only.
ALL_OF_RANGES = {
    "sample": BLOCKS, "simulate": BATCHES, "replicates": 4, **each("join_cases", "provenance"),
    **AFTER_SIMULATION, **SCENES,
}  # fmt: skip
ALL_OF_SIMULATION = {**ALL_OF_RANGES, "figure_generation": 1}
EVERYTHING = {**ALL_OF_SIMULATION, **each("rule_graph", "figure_rules")}


class Project:
    """A copy of the project in its own folder, run with its own sources."""

    def __init__(self, root):
        self.root = root
        for name in ("Snakefile", "config.yaml"):
            shutil.copy2(ROOT / name, root)
        for name in ("studies", "workflow", "profiles", "src/abradem"):
            shutil.copytree(ROOT / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
        self.results = root / "results" / "smoke"
        # Edited kernels are compiled faster with less optimisation, and in a cache of their own.
        self.environment = {
            **os.environ,
            "PYTHONPATH": str(root / "src"),
            "ABRADEM_CACHE_DIR": str(root / "cache"),
            "NUMBA_OPT": "1",
        }
        self.copy_kernels()
        self.loaded = None

    def copy_kernels(self):
        """Those of the sources as they are, which were compiled once for this machine."""
        warm()
        folder = self.root / "cache" / cache_folder().name
        folder.mkdir(parents=True)
        # An index is written after the machine code that it names.
        for suffix in ("nbi", "nbc"):
            for path in cache_folder().glob(f"*.{suffix}"):
                shutil.copy2(path, folder)

    def command(self, *arguments, overlays=(SMOKE,)):
        return [
            sys.executable, "-m", "snakemake", *self.arguments(*arguments, overlays=overlays),
        ]  # fmt: skip

    @staticmethod
    def arguments(*arguments, overlays):
        return [*arguments, "--configfile", "config.yaml", *map(str, overlays)]

    def snakemake(self, *arguments, overlays=(SMOKE,), **environment):
        return subprocess.run(
            self.command(*arguments, overlays=overlays),
            cwd=self.root, env={**self.environment, **environment}, text=True, check=False,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=900,
        )  # fmt: skip

    def doctor(self, *options):
        """Examine the smoke study."""
        return subprocess.run(
            [sys.executable, "-m", "abradem.cli.main", "doctor", "results/smoke", *options],
            cwd=self.root, env=self.environment, text=True, check=False, capture_output=True,
        )  # fmt: skip

    def run(self, *arguments, overlays=(SMOKE,)):
        """Run and return how many jobs of each rule were run."""
        done = self.snakemake(*arguments, overlays=overlays)
        assert done.returncode == 0, done.stdout
        return job_counts(done.stdout)

    def pending(self, *targets, overlays=(SMOKE,)):
        """How many jobs of each rule a run would do."""
        status, said = self.loaded(*self.arguments("--dry-run", *targets, overlays=overlays))
        assert status == 0, said
        return job_counts(said)

    def overlay(self, values):
        """An override file on the smoke study that holds nested ``values``."""
        path = self.root / "studies" / "change.yaml"
        path.write_text(yaml.safe_dump(values))
        return (SMOKE, "studies/change.yaml")

    @contextlib.contextmanager
    def edited(self, file, old, new):
        """One edited place in a file, restored at the end."""
        path = self.root / file
        text = path.read_text(encoding="utf-8")
        assert text.count(old) == 1, f"{file} holds {old!r} {text.count(old)} times"
        path.write_text(text.replace(old, new), encoding="utf-8")
        try:
            yield
        finally:
            path.write_text(text, encoding="utf-8")


def job_counts(text):
    """Jobs of each rule, from the last table of jobs that snakemake printed."""
    tables = re.findall(r"^job +count\n[- ]+\n(.*?)^total", text, re.MULTILINE | re.DOTALL)
    if not tables:
        assert "Nothing to be done" in text, text
        return {}
    return {name: int(count) for name, count in map(str.split, tables[-1].splitlines())}


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """The project after a full run of the smoke study."""
    project = Project(tmp_path_factory.mktemp("project"))
    project.first = project.snakemake()
    assert project.first.returncode == 0, project.first.stdout
    said = project.root / "said.txt"
    with loaded_snakemake(project.root, project.environment, said) as project.loaded:
        yield project


def test_a_full_run_runs_every_rule(project):
    assert job_counts(project.first.stdout) == EVERYTHING


def test_a_run_says_what_it_will_do_and_how_far_it_is(project):
    assert (
        "smoke: 12 cases in 2 blocks, 4 simulation jobs, simulated in about" in project.first.stdout
    )
    assert re.search(r"^simulations: 12 of 12 cases done in", project.first.stdout, re.MULTILINE)


def test_every_case_is_in_the_data_set_or_among_the_failures(project):
    cases, dataset, failures = (
        read_table(project.results / f"{name}.parquet") for name in ("cases", "dataset", "failures")
    )
    found = sorted([*dataset["case_id"], *failures["case_id"]])
    assert found == cases["case_id"].tolist() == list(range(12))
    assert len(dataset) > 0 and (dataset["status"] == "ok").all()


def test_the_processor_time_of_every_case_stands_beside_the_results(project):
    parts = sorted((project.results / "benchmarks" / "cases").glob("*.parquet"))
    times = pd.concat(read_table(part) for part in parts)
    assert len(parts) == BATCHES and times["case_id"].tolist() == list(range(12))
    assert (times["processor_time"] > 0.0).all()


def test_configuration_versions_and_seed_stand_beside_the_results(project):
    resolved = yaml.safe_load((project.results / "config.yaml").read_text())
    assert resolved["sampling"]["cases_per_block"] == 6 and "gravity" in resolved["simulation"]
    recorded = json.loads((project.results / "versions.json").read_text())
    assert recorded["seed"] == 1 and {"python", "numpy"} <= recorded["versions"].keys()


def test_no_file_of_the_way_is_left(project):
    left = [path for path in project.results.rglob(".*")]
    assert left == []


def test_a_batch_takes_half_the_memory_that_it_asks_a_cluster_for(project):
    shown = project.snakemake(
        "simulation", "--dry-run", "--forcerun", "simulate", "--quiet", "host"
    ).stdout
    asked = re.findall(r"^rule simulate:\n(?:    .*\n)*?.*\bmem_mb=(\d+)", shown, re.MULTILINE)
    measured = (project.results / "benchmarks" / "simulate").glob("*.tsv")
    used = [pd.read_csv(path, sep="\t")["max_rss"].max() for path in measured]
    assert len(asked) == len(used) == BATCHES
    assert max(used) < min(map(int, asked)) / 2


def test_nothing_is_to_be_done_after_a_run(project):
    assert project.pending() == {}


def test_jobs_that_ended_cost_no_more_looks_at_those_that_wait(project):
    """The rate limit of Snakemake, which is removed, would check every job once a second."""
    done = project.snakemake("--forcerun", "simulate", "--cores", "1", "--verbose", "dataset")
    assert done.returncode == 0, done.stdout
    jobs = sum(job_counts(done.stdout).values())
    assert jobs > 2 * BATCHES
    assert done.stdout.count("Ready jobs: ") < 2 * jobs


def test_a_touch_reruns_nothing(project):
    for folder in ("src", "workflow", "studies", "results/smoke/cases", "results/smoke/runs"):
        for path in (project.root / folder).rglob("*.*"):
            path.touch()
    for file in ("Snakefile", "config.yaml"):
        (project.root / file).touch()
    assert project.pending() == {}


@pytest.mark.parametrize(
    "stage",
    ["sampling", "simulation", "wear", "dataset", "baselines", "physical", "learning", "figures",
     "documents"],
)  # fmt: skip
def test_each_stage_is_a_target(project, stage):
    assert project.pending(stage) == {}


def test_the_report_holds_all_and_needs_no_network(project):
    report = project.results / "report.html"
    sheet = "workflow/report/report.css"
    made = project.snakemake("--report", str(report), "--report-stylesheet", sheet)
    assert made.returncode == 0, made.stdout
    assert "WARNING" not in made.stdout
    html = report.read_text(encoding="utf-8")
    for name in (
        "series", "maps", "quality", "coefficients", "residuals", "predicted_linear", "penalised",
        "selection", "correlations", "loadings", "components", "tree_depth", "tree", "ga_ann",
        "comparison", "predictions",
    ):  # fmt: skip
        assert f"figures/{name}.png" in html
    for name in (
        "dataset.parquet",
        "linear.json",
        "tables/dataset.html",
        "tables/scores.html",
        "tables/beside_paper.html",
        "tables/failures.html",
    ):
        assert name in html
    assert "12 of 12" in html and "cases gave no rate" in html
    # Captions are texts of the report, not of the pictures.
    assert "central share of the repeated splits" in html
    assert not re.search(r'<(script|link|img)[^>]+(src|href)="https?:', html)
    assert project.pending() == {}
    assert_first_screen_shows_the_result(report)


def assert_first_screen_shows_the_result(report):
    """Title, models, what failed and the run time are seen at once; the top can be reached."""
    there = "return document.querySelector('.overview + p') !== null"
    places = (
        "const places = (word) => {const {top, bottom, right} ="
        " document.querySelector(word).getBoundingClientRect(); return [top, bottom, right]};"
        "return ['.overview h1', '.overview .models', '.overview .failed', '.overview + p']"
        ".map(places).concat([[document.documentElement.scrollWidth, 0, 0]])"
    )
    with opened(report, lambda driver: wait_for(driver, there)) as driver:
        for name in ("desktop", "wide", "large", "phone"):
            width, height = ROOMS[name]
            show(driver, name)
            *seen, (needed, _, _) = driver.execute_script(places)
            assert needed <= width and all(right <= width for _, _, right in seen)
            assert seen[0][0] >= 0.0
            if name != "phone":
                assert all(bottom <= height for _, bottom, _ in seen)
        assert driver.find_element("css selector", ".overview + p").text.startswith("Run time: ")


def test_every_figure_of_the_list_is_there_in_every_format(project):
    # A study shows two figures if their results exist, a calibration and a geometry their own.
    own = (CALIBRATION, SURFACE)
    names = {name for name, entry in CATALOGUE.items() if entry.group not in own}
    names -= {"verification", "speed"}
    for suffix in ("png", "pdf"):
        found = {path.stem for path in (project.results / "figures").glob(f"*.{suffix}")}
        assert found == names


def test_no_number_for_latex_differs_from_its_source(project):
    folder = project.results / "latex"
    files = {
        file: read_result(project.results / file)
        for file in (
            latex.DATASET, latex.SUMMARY, latex.COMPARISON, latex.BESIDE, latex.SCORES,
            latex.SELECTION, *latex.NETWORKS.values(),
        )
    }  # fmt: skip
    config = yaml.safe_load((project.results / "config.yaml").read_text())
    found = latex.CitedResults({**files, latex.CONFIG: config})
    defined = macros((folder / "numbers.tex").read_text())
    assert len(defined) > 80
    for _, text, source in defined:
        assert_agree(text, at_source(found, source))
    for name in ("quantities", "features", "models"):
        for cells, sources in rows((folder / f"{name}.tex").read_text()):
            numbers = [cell for cell in cells if is_number(cell)]
            for cell, source in zip(numbers, sources, strict=True):
                assert_agree(cell, at_source(found, source))


def test_files_for_paraview_are_made_on_demand(project):
    assert project.run("vtk") == {"vtk_of_scene": 1, "vtk": 1}
    folder = project.results / "vtk" / "typical"
    assert (folder / "particles.pvd").exists() and (folder / "plate_00000.vtp").exists()


# Jobs that rerun after an edit of the code


WORDS = {**FIGURES, **each("latex", "findings", "summary", "model_card", "explorer")}
"""What shows labels of quantities, groups, models or protocols."""

SOURCES = "src/abradem"


@pytest.mark.parametrize(
    ("file", "jobs"),
    [
        # Display names and helpers of figures rerun no simulation and no training.
        (f"{SOURCES}/words/labels.py", WORDS),
        (f"{SOURCES}/figures/style.py", FIGURES),
        (f"{SOURCES}/figures/catalogue.py", {}),
        (f"{SOURCES}/figures/maps.py", each("figure_maps", "figure_gallery")),
        (f"{SOURCES}/figures/cases_shown.py", OF_SIMULATIONS),
        (f"{SOURCES}/figures/series.py", each("figure_series")),
        (f"{SOURCES}/figures/quality.py", each("figure_quality")),
        (f"{SOURCES}/figures/linear.py", each("figure_coefficients", "figure_predicted_linear")),
        (f"{SOURCES}/figures/residuals.py", each("figure_residuals")),
        (f"{SOURCES}/figures/setup.py", each("figure_setup")),
        (f"{SOURCES}/figures/flow.py", OF_CHARTS),
        (f"{SOURCES}/figures/pca.py", OF_PCA),
        ("workflow/scripts/figures/figure.py", FIGURES),
        (f"{SOURCES}/report/latex.py", each("latex")),
        (f"{SOURCES}/report/findings.py", each("findings")),
        (f"{SOURCES}/report/model_card.py", each("model_card")),
        (f"{SOURCES}/report/summary.py", each("summary", "latex", "overview")),
        (f"{SOURCES}/report/explorer.py", each("explorer")),
        (f"{SOURCES}/report/scene.py", each("scene_page")),
        (f"{SOURCES}/learning/physical/wear_maps.py", each("wear_maps", "explorer")),
        # Models.
        (f"{SOURCES}/learning/baselines/linear.py", {
            **AFTER_SCORES, "linear": 1, **OF_LINEAR, "table": 6,
        }),
        (f"{SOURCES}/learning/baselines/trees.py", {**AFTER_SCORES, "trees": 1, **OF_TREES}),
        (f"{SOURCES}/learning/baselines/genetic.py", {**AFTER_SCORES, "ga_ann": 2, **OF_GA_ANN}),
        (f"{SOURCES}/learning/comparison.py", AFTER_SCORES),
        (f"{SOURCES}/learning/physical/noise_floor.py", {
            **each("noise_floor", "findings", "figure_models", "overview"),
        }),
        # Data.
        (f"{SOURCES}/dataset/features.py", AFTER_WEAR_RATES),
        (f"{SOURCES}/dataset/join.py", {**AFTER_WEAR_RATES}),
        (f"{SOURCES}/wear/rates.py", {
            **AFTER_SIMULATION, "replicates": 4, **SCENES,
            "scene": 0, "scene_page": 0, "figure_setup": 0,
        }),
        (f"{SOURCES}/wear/depths.py", each("figure_setup", "scene_page")),
        (f"{SOURCES}/simulation/batch.py", {
            k: v for k, v in ALL_OF_SIMULATION.items()
            if k not in ("sample", "join_cases", "scene", "scene_page", "angles", "figure_setup",
                         "figure_angles", "figure_generation", "provenance")
        }),
        (f"{SOURCES}/dem/synchronous.py", {
            k: v for k, v in ALL_OF_SIMULATION.items()
            if k not in ("sample", "join_cases", "figure_generation", "provenance")
        }),
        (f"{SOURCES}/dem/model.py", {**ALL_OF_SIMULATION, "figure_rules": 1}),
        (f"{SOURCES}/elastic.py", {**ALL_OF_SIMULATION, "figure_rules": 1}),
        (f"{SOURCES}/quantities.py", {**EVERYTHING, "rule_graph": 0}),
        # Storage, configuration and support for running.
        ("workflow/scripts/report/table.py", {"table": 17}),
        (f"{SOURCES}/store/columns.py", {}),
        (f"{SOURCES}/store/files.py", {}),
        (f"{SOURCES}/store/tables.py", {}),
        (f"{SOURCES}/store/locks.py", {}),
        (f"{SOURCES}/config/declaration.py", {}),
        (f"{SOURCES}/running/progress.py", {}),
        (f"{SOURCES}/sampling/cost.py", {}),
        (f"{SOURCES}/report/tables.py", {}),
    ],
)  # fmt: skip
def test_an_edited_module_reruns_its_steps_and_what_follows(project, file, jobs):
    path = project.root / file
    text = path.read_text(encoding="utf-8")
    path.write_text(text + "# edited\n", encoding="utf-8")
    try:
        pending = project.pending()
    finally:
        path.write_text(text, encoding="utf-8")
    # Hashes of the code are recorded, so this file changes with any relevant edit.
    expected = {**jobs, "provenance": 1, "all": 1} if jobs else {}
    assert pending == {rule: count for rule, count in expected.items() if count}


@pytest.mark.parametrize(
    ("file", "old", "new", "jobs"),
    [
        (f"{SOURCES}/words/labels.py", '"plate angle"),\n    "factory', '"tilt"),\n    "factory',
         WORDS),
        (f"{SOURCES}/figures/catalogue.py", "Wear depth rate on the facets", "Rate on facets",
         each("figure_maps")),
        (f"{SOURCES}/figures/catalogue.py", '"wear on the plate"', '"worn plate"', {}),
        (f"{SOURCES}/report/tables.py", "Scores of the models: one row", "One row", {"table": 1}),
    ],
)  # fmt: skip
def test_an_edited_label_or_caption_repeats_no_simulation_and_no_training(
    project, file, old, new, jobs
):
    with project.edited(file, old, new):
        pending = project.pending()
    assert not pending.keys() & {"sample", "simulate", "wear_rates", "dataset", *TRAINING} - {
        "findings"
    }
    for rule in ("provenance", "all"):
        pending.pop(rule, None)
    assert pending == jobs


def test_an_edited_rule_redraws_the_graph_of_rules(project):
    with project.edited(
        "workflow/rules/report.smk", "rule documents:", "# edited\nrule documents:"
    ):
        assert project.pending() == {"rule_graph": 1, **OF_CHARTS, "all": 1}


def test_an_edited_contact_kernel_is_what_the_simulations_then_use(project):
    batch = "results/smoke/series/block-000-batch-000.parquet"
    before = (project.root / batch).read_bytes()
    others = [f"series/block-{b:03d}-batch-{s:03d}.parquet" for b, s in ((0, 1), (1, 0), (1, 1))]
    kept = {name: (project.results / name).read_bytes() for name in others}
    with project.edited(
        "src/abradem/dem/contact.py",
        "force = fma(law.kn * overlap, s,",
        "force = fma(1.2 * law.kn * overlap, s,",
    ):
        assert project.pending("simulation")["simulate"] == BATCHES
        assert project.run(batch)["simulate"] == 1
        assert (project.root / batch).read_bytes() != before
    project.run(batch)
    assert (project.root / batch).read_bytes() == before
    assert project.pending() == {}
    assert kept == {name: (project.results / name).read_bytes() for name in others}


# Jobs that rerun after a change of the configuration


@pytest.mark.parametrize(
    ("values", "jobs"),
    [
        ({"sampling": {"ranges": {"restitution": [0.3, 0.8]}}}, ALL_OF_RANGES),
        ({"seed": 2}, ALL_OF_SIMULATION),
        ({"simulation": {"stop": {"max_time_s": 4.0}}}, ALL_OF_SIMULATION),
        ({"wear_rate": {"footprint_share": 0.9}}, {
            **{k: v for k, v in AFTER_SIMULATION.items() if k not in OF_SIMULATIONS},
            "replicates": 4,
        }),
        ({"wear_rate": {"good_r2": 0.9}}, each("figure_quality", "summary", "latex", "overview")),
        ({"features": {"damping_coefficient": "printed"}}, {
            "dataset": 1, **AFTER_DATASET, "table": 16,
        }),
        ({"simulation": {"max_failed_share": 0.5}}, {"dataset": 1, **AFTER_DATASET, "table": 16}),
        ({"learning": {"trees": {"forest_trees": 9}}}, {
            **AFTER_SCORES, "trees": 1, **OF_TREES,
        }),
        ({"learning": {"ga_ann": {"mutation": 0.3}}}, {
            **AFTER_SCORES, "ga_ann": 2, **OF_GA_ANN,
        }),
        ({"learning": {"bootstrap": 300}}, AFTER_SCORES),
        ({"learning": {"penalised": {"path_points": 9}}}, {
            **AFTER_SCORES, "penalised": 1, "figure_penalised": 1, "table": 5,
        }),
        ({"figures": {"series_cases": [1, 2]}}, {"figure_series": 1, "figure_maps": 1}),
        ({"figures": {"typical": {"plate_angle": 20}}}, SCENES),
        ({"figures": {"angles": {"plate": [10]}}}, {"angles": 1, "figure_angles": 1}),
        ({"figures": {"movie": {"duration_s": 1}}}, {}),
        ({"simulation": {"export": {"cases": [1]}}}, {"snapshots_of_case": 1}),
    ],
)  # fmt: skip
def test_a_changed_value_reruns_what_depends_on_it(project, values, jobs):
    pending = project.pending(overlays=project.overlay(values))
    assert pending == {**jobs, "provenance": 1, "all": 1}


def test_one_case_per_job_is_possible(project):
    overlays = project.overlay({"simulation": {"cases_per_job": 1}})
    assert project.pending("simulation", overlays=overlays)["simulate"] == 12


def test_an_export_holds_snapshots_of_its_case_and_reruns_no_simulation(project):
    export = {"cases": [1], "interval_s": 0.25}
    overlays = project.overlay({"simulation": {"export": export}})
    assert project.run("snapshots", overlays=overlays) == {
        "snapshots_of_case": 1, "snapshots": 1,
    }  # fmt: skip
    folder = project.results / "export" / "case-1"
    particles = read_table(folder / "particles.parquet")
    assert particles["time"].nunique() > 2 and particles["y"].notna().all()
    assert {path.stem for path in folder.iterdir()} == {"particles", "contacts", "wear"}


# External table


def external_overlay(project, **values):
    path = project.root / "studies" / "elsewhere.yaml"
    learning = yaml.safe_load((project.root / SMOKE).read_text())["learning"]
    learning["target"] = "wear_total_mean"
    path.write_text(yaml.safe_dump({"study": "elsewhere", "dataset": values, "learning": learning}))
    return ("studies/elsewhere.yaml",)


def test_an_external_table_is_learned_from_and_nothing_is_simulated(project):
    table = product_law(24)[[*SAMPLED_NAMES, "wear_total_mean"]]
    table.rename(columns={"plate_angle": "slope"}).to_csv(project.root / "t.csv", index=False)
    overlays = external_overlay(project, external="t.csv", columns={"plate_angle": "slope"})
    pending = project.pending(overlays=overlays)
    assert pending == {
        "dataset": 1, "provenance": 1, "all": 1, "rule_graph": 1, **OF_CHARTS, **LEARNING,
        "table": 16,
    }  # fmt: skip
    assert project.run("dataset", overlays=overlays) == {"dataset": 1}
    found = read_table(project.root / "results" / "elsewhere" / "dataset.parquet")
    assert len(found) == 24 and "plate_angle" in found
    project.run("results/elsewhere/summary.json", overlays=overlays)
    summary = json.loads((project.root / "results" / "elsewhere" / "summary.json").read_text())
    assert summary["external"] == "t.csv" and summary["cases"] == 24


def test_a_bad_external_table_is_one_line_for_each_problem(project):
    table = product_law(24)[[*SAMPLED_NAMES, "wear_total_mean"]]
    table.loc[4, "restitution"] = 2.0
    table.to_csv(project.root / "bad.csv", index=False)
    overlays = external_overlay(project, external="bad.csv")
    refused = project.snakemake("dataset", overlays=overlays)
    assert refused.returncode != 0
    line = "bad.csv: row 5: restitution = 2 must lie in [0.05, 1] 1"
    assert any(text.startswith(line) for text in refused.stdout.splitlines())
    overlays = external_overlay(project, external="nowhere.csv")
    refused = project.snakemake("--dry-run", overlays=overlays)
    assert refused.stdout.splitlines()[-1] == (
        "dataset.external: nowhere.csv: there is no such file"
    )


# Growth


def test_more_blocks_run_only_their_own_cases(project):
    assert project.pending(overlays=GROWN) == {
        "sample": 2, "simulate": 4, "wear_rates": 4, "join_cases": 1, "provenance": 1,
        "figure_gallery": 1, "figure_generation": 1, **AFTER_WEAR_RATES,
    }  # fmt: skip


def test_fewer_blocks_run_only_the_joins(project):
    overlays = project.overlay({"sampling": {"blocks": 1}, "figures": {"series_cases": [0, 1]}})
    pending = project.pending(overlays=overlays)
    assert pending == {
        "join_cases": 1, "provenance": 1, **OF_SIMULATIONS, "figure_generation": 1,
        **AFTER_WEAR_RATES,
    }  # fmt: skip


def test_growing_shrinking_and_another_study_leave_finished_simulations_alone(project):
    def finished(study="smoke"):
        folder = project.root / "results" / study
        tables = [path for name in ("cases", "series", "maps", "parts", "runs", "wear_rates")
                  for path in sorted((folder / name).glob("block-*.parquet"))]  # fmt: skip
        return {str(path.relative_to(folder)): (path.stat().st_mtime_ns, path.read_bytes())
                for path in tables}  # fmt: skip

    before = finished()
    grown = GROWN
    assert project.run("simulation", overlays=grown) == {
        "sample": 2, "simulate": 4, "provenance": 1, "simulation": 1,
    }  # fmt: skip
    assert {name: finished()[name] for name in before} == before
    assert project.run("simulation") == {"provenance": 1, "simulation": 1}
    other = project.overlay({"study": "other", "seed": 2})
    assert project.run("sampling", overlays=other) == {"sample": 2, "join_cases": 1, "sampling": 1}
    assert finished("other").keys() < before.keys()
    assert {name: finished()[name] for name in before} == before
    assert project.pending("simulation") == project.pending("sampling", overlays=other) == {}
    # The results of the larger study are kept.
    assert project.pending("simulation", overlays=grown) == {"provenance": 1, "simulation": 1}


def test_two_studies_at_once_in_one_folder_make_what_each_makes_alone(project):
    """The smoke study under two other names, in simultaneous runs."""
    names = ("left", "right")
    overlays = {}
    for name in names:
        # The path of the override file is shared, so each run gets its own file.
        overlays[name] = (SMOKE, project.root / f"{name}.yaml")
        overlays[name][1].write_text(f"study: {name}\n", encoding="utf-8")
    runs = [
        subprocess.Popen(
            project.command("simulation", "--cores", "1", overlays=overlays[name]),
            cwd=project.root, env=project.environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )
        for name in names
    ]  # fmt: skip
    for run in runs:
        said, _ = run.communicate(timeout=600)
        assert run.returncode == 0, said
    for name in names:
        for part in ("cases", "series", "maps", "parts", "runs"):
            together = sorted((project.root / "results" / name / part).glob("block-*.parquet"))
            assert len(together) == (2 if part == "cases" else BATCHES)
            for path in together:
                assert path.read_bytes() == (project.results / part / path.name).read_bytes()


# On demand


def test_a_published_folder_lists_all_that_a_study_made(project):
    assert project.run("publish") == {"published_folder": 1, "publish": 1}
    folder = project.results / "publish"
    graph = json.loads((folder / "ro-crate-metadata.json").read_text())["@graph"]
    listed = {entity["@id"] for entity in graph if entity["@type"] == "File"}
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert listed == found - {"ro-crate-metadata.json"}
    figures = {path.name for path in (project.results / "figures").iterdir()}
    assert figures == {path.name for path in (folder / "figures").iterdir()}
    assert {"models/surrogate.safetensors", "learning/scores.parquet"} < found
    assert len(list((folder / "maps").glob("block=*/*.parquet"))) == BATCHES
    assert project.pending("publish") == {}


def test_every_rule_says_what_it_makes(project):
    listed = project.snakemake("--list").stdout.splitlines()
    rules = [line for line in listed if re.match(r"[a-z_]+( |$)", line)]
    assert len(rules) > 60
    assert [line for line in rules if not re.fullmatch(r"[a-z_]+ \(.+\.\)", line)] == []


# Interruptions and errors


def test_a_killed_run_continues_to_the_same_bytes(project):
    overlays = project.overlay({"study": "killed"})
    results = project.root / "results" / "killed"
    with subprocess.Popen(
        project.command("simulation", "--cores", "2", overlays=overlays),
        cwd=project.root, env=project.environment, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    ) as run:  # fmt: skip
        while not list(results.glob(".finished/*/started")) and run.poll() is None:
            time.sleep(0.02)
        os.killpg(run.pid, signal.SIGKILL)
    assert list(results.glob(".finished/*/started"))
    assert project.run("simulation", overlays=overlays)["simulate"] > 0
    assert project.pending("simulation", overlays=overlays) == {}
    for name in ("series", "maps", "parts", "runs"):
        paths = sorted((results / name).glob("*.parquet"))
        assert paths
        for path in paths:
            assert (project.results / name / path.name).read_bytes() == path.read_bytes()
    assert not (results / ".finished").exists()


def test_models_killed_in_their_training_and_trained_on_one_core_are_the_same(project):
    timings = {"speed_up.json", "findings.html"}

    def content():
        return {
            path.relative_to(project.results): path.read_bytes()
            for name in ("learning", "models")
            for path in sorted((project.results / name).rglob("*"))
            if path.is_file() and path.name not in timings
        }

    before = content()
    again = [
        "linear", "penalised", "pca", "trees", "ga_ann", "fit_physical", "intervals", "surrogate",
        "wear_maps",
    ]  # fmt: skip
    with subprocess.Popen(
        project.command("learning", "--forcerun", *again, "--cores", "2"),
        cwd=project.root, env=project.environment, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    ) as run:  # fmt: skip
        # Outputs are deleted when their job starts.
        while set(before) <= set(content()) and run.poll() is None:
            time.sleep(0.02)
        os.killpg(run.pid, signal.SIGKILL)
    assert not set(before) <= set(content())
    jobs = project.run("learning", "--forcerun", *again, "--cores", "1")
    assert set(again) <= set(jobs)
    assert content() == before


def test_every_output_of_the_run_has_a_checksum(project):
    """All but what Snakemake writes itself."""
    results = {
        path.relative_to(project.results).as_posix()
        for path in project.results.rglob("*.*")
        if path.is_file() and path.suffix not in (".log", ".tsv", ".sha256")
    }
    with_record = set(recorded(project.results))
    assert {name for name in results if not name.startswith(("report.html", "vtk/"))} <= with_record
    assert len(results) > 150


def test_damage_is_found_named_and_healed_by_the_command_that_is_named(project):
    """A table that jobs read, a model and a figure that nothing reads, a summary of the report."""
    harmed = ["dataset.parquet", "learning/forest.safetensors", "figures/tree.png", "summary.json"]
    before = {name: (project.results / name).read_bytes() for name in harmed}
    for name in harmed:
        content = bytearray(before[name])
        content[len(content) // 2] ^= 1
        (project.results / name).write_bytes(content)
    stopped = project.snakemake("linear")
    assert stopped.returncode != 0
    line = next(line for line in stopped.stdout.splitlines() if line.startswith("results/smoke/d"))
    assert line == (
        "results/smoke/dataset.parquet: damaged, differs from what its job wrote; "
        "`abradem doctor results/smoke --delete` removes what is damaged, and the next run makes "
        "it again (see results/smoke/logs/linear.log)"
    )
    examined = project.doctor()
    assert examined.returncode == 1
    assert {line.split(": ")[0] for line in examined.stdout.splitlines()} >= {
        f"results/smoke/{name}" for name in harmed
    }
    command = examined.stdout.splitlines()[-1].partition(": snakemake --configfile ")[2].split()
    healed = project.snakemake(*command[1:], overlays=command[:1])
    assert healed.returncode == 0, healed.stdout
    assert before == {name: (project.results / name).read_bytes() for name in harmed}
    assert project.doctor().returncode == 0
    assert project.pending() == {}


def test_what_was_deleted_as_damaged_is_made_by_the_next_run(project):
    """The arrays of a tree are an output that no job reads and no target asks for."""
    path = project.results / "learning" / "tree.safetensors"
    before = path.read_bytes()
    path.write_bytes(before[:-8])
    assert project.pending() == {}
    assert project.doctor("--delete").returncode == 1
    assert project.run()["trees"] == 1
    assert path.read_bytes() == before
    assert project.doctor().returncode == 0 and project.pending() == {}


def test_only_the_cases_that_a_target_needs_are_counted(project):
    table = "results/smoke/runs/block-000-batch-000.parquet"
    said = project.snakemake("--force", table).stdout
    assert "smoke: 3 of 12 cases are to be simulated" in said
    assert re.search(r"^simulations: 3 of 3 cases done in", said, re.MULTILINE)
    said = project.snakemake("--force", "results/smoke/cases/block-000.parquet").stdout
    assert "cases" not in re.sub(r"results/\S+|^(rule|.*output).*$", "", said, flags=re.MULTILINE)
    assert project.run().keys() <= {"all", "rule_graph"}


def test_a_failing_step_is_one_line_and_leaves_the_failures(project):
    with project.edited(
        "src/abradem/dataset/join.py",
        "    missing = [name for name in DATASET_COLUMNS if name not in",
        "    raise TableError('case 3 is odd')\n"
        "    missing = [name for name in DATASET_COLUMNS if name not in",
    ):  # fmt: skip
        failed = project.snakemake("dataset")
    assert failed.returncode != 0
    assert "case 3 is odd (see results/smoke/logs/dataset.log)" in failed.stdout.splitlines()
    assert (project.results / "failures.parquet").exists()
    # What follows is up to date, as the data set is made again with the same content.
    assert project.run("dataset") == each("failures", "dataset")
    assert project.pending() == {}


def test_a_malformed_configuration_is_one_line(project):
    overlays = project.overlay({"sampling": {"ranges": {"restitution": [0.9, 0.2]}}})
    refused = project.snakemake("--dry-run", overlays=overlays)
    assert refused.returncode != 0
    lines = [line for line in refused.stdout.splitlines() if "restitution" in line]
    assert len(lines) == 1 and lines[0].startswith("studies/change.yaml: sampling.ranges.")
    assert "Traceback" not in refused.stdout


def test_a_configuration_that_would_run_code_is_one_line(project):
    """Snakemake reads configurations as templates with expressions."""
    template = "__use_yte__: true\nseed: ?open('pwned', 'w').close() or 1 "
    with project.edited("config.yaml", "\nseed: 1 ", f"\n{template}"):
        # With --configfile Snakemake reads the file before this workflow does.
        refused = subprocess.run(
            [sys.executable, "-m", "snakemake", "--dry-run"], cwd=project.root,
            env=project.environment, text=True, check=False,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=900,
        )  # fmt: skip
    assert refused.returncode != 0
    assert refused.stdout.splitlines()[-1] == "config.yaml: __use_yte__: templates are refused"
    assert not (project.root / "pwned").exists()


def test_too_many_failures_stop_the_run_before_the_data_set(project):
    overlays = project.overlay({
        "study": "failing",
        "sampling": {"blocks": 1, "ranges": {
            "particle_shear_modulus_gpa": 0.001, "particle_velocity_y": -10,
        }},
        "figures": {"series_cases": [0]},
    })  # fmt: skip
    failed = project.snakemake("dataset", overlays=overlays)
    assert failed.returncode != 0
    # Said before the first case is simulated.
    assert (
        "6 of 6 cases are inconsistent" in failed.stdout
        and "too soft for this speed" in failed.stdout
    )
    assert "(allowed 20%, simulation.max_failed_share)" in failed.stdout
    assert not (project.root / "results" / "failing" / "dataset.parquet").exists()


def test_without_the_package_the_answer_is_one_line(project, tmp_path):
    (tmp_path / "sitecustomize.py").write_text(
        "import sys\n"
        "class Missing:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'abradem':\n"
        "            raise ModuleNotFoundError(name, name=name)\n"
        "sys.meta_path.insert(0, Missing())\n"
    )
    refused = project.snakemake("--dry-run", PYTHONPATH=str(tmp_path))
    assert refused.returncode != 0
    assert "pip install -e ." in refused.stdout.splitlines()[-1]
    assert "Traceback" not in refused.stdout


def test_the_workflow_has_no_lint(project):
    lint = project.snakemake("--lint")
    assert lint.returncode == 0, lint.stdout
