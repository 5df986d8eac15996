"""Tables and numbers for LaTeX: every number agrees with the source that it states."""

import math
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from latex_checks import assert_agree, at_source, is_number, macros, rows
from tables import product_law

from abradem.config import load_config
from abradem.report import latex
from abradem.report.typeset import PROGRAMS, TypesetError, find_program, typeset

ROOT = Path(__file__).parents[2]


def results():
    """Files of a small study with missing, very large and negative values."""
    models = ("linear", "pca_wrong_target", "ga_ann")
    rng = np.random.default_rng(0)
    dataset = product_law(12).assign(simulated_time=rng.uniform(5.0, 9.0, 12))
    comparison = pd.DataFrame(
        [
            {
                "model": model, "protocol": protocol, "basis": basis, "repeats": 4,
                "r2": r2, "r2_lower": r2 - 0.1, "r2_upper": math.nan,
            }
            for model, protocol, basis, r2 in (
                ("linear", "leakage_free", "repeated splits", 0.604),
                ("linear", "leakage_free", "fixed split", -1.2e31),
                ("linear", "as_published", "fixed split", -0.0004),
                ("pca_wrong_target", "as_published", "fixed split", -0.2449),
                ("ga_ann", "leakage_free", "fixed split", -123456.7),
                ("ga_ann", "as_published", "fixed split", 0.931),
            )
        ]
    )  # fmt: skip
    beside = pd.DataFrame(
        {
            "model": models, "printed_r2": [0.68, -0.21, math.nan],
            "as_published_r2": [0.54, -0.24, 0.93], "leakage_free_r2": [0.6, math.nan, 0.9],
            "leakage_free_lower": [0.3, math.nan, -4e9],
            "leakage_free_upper": [0.7, math.nan, 0.94],
            "basis": ["repeated splits", "", "fixed split"],
        }
    )  # fmt: skip
    scores = pd.DataFrame(
        [
            {
                "model": model, "protocol": "leakage_free", "split": "test", "metric": metric,
                "value": rng.uniform(1e-5, 1e-3),
            }
            for model in ("linear", "ga_ann")
            for metric in ("RMSE", "MAE")
            for _ in range(4)
        ]
    )  # fmt: skip
    selection = pd.DataFrame(
        [
            {
                "feature": name, "protocol": protocol, "in_paper": index < 3,
                "chosen_by": "weight" if index % 2 else "",
            }
            for protocol in ("as_published", "leakage_free")
            for index, name in enumerate(latex.FEATURE_NAMES)
        ]
    )  # fmt: skip
    network = {"architecture": [361, 12], "best_fitness": 0.976, "networks_trained": 164}
    checks = pd.DataFrame({"part": [1, 1, 4], "verdict": ["holds", "FAILS", "holds"]})
    exponents = pd.DataFrame(
        {
            "quantity": ["particle_radius", "impact_speed"], "exponent": [0.914, np.nan],
            "exponent_stderr": [0.05, np.nan], "published_exponent": [0.87, 0.99],
            "published_stderr": 0.02, "verdict": ["agrees", "not determined"],
        }
    )  # fmt: skip
    summary = {
        "external": None, "cases": 13, "failures": 1, "cases_without_flag": 11,
        "cases_with_good_r2": 12, "good_r2": 0.95, "median_relative_stderr": 0.01447,
        "target": "wear_total_mean", "target_words": "wear depth rate, total, mean over the plate",
    }  # fmt: skip
    return latex.CitedResults(
        {
            latex.CONFIG: load_config({"study": "a_study"}).model_dump(mode="json"),
            latex.DATASET: dataset,
            latex.SUMMARY: summary,
            latex.COMPARISON: comparison,
            latex.BESIDE: beside,
            latex.SCORES: scores,
            latex.SELECTION: selection,
            latex.EXPONENTS: exponents,
            latex.CHECKS: checks,
            **{file: network for file in latex.NETWORKS.values()},
        }
    )


PARTS = {1: "Closed forms", 4: "Time step & more"}
NAMES = {"linear": "least squares"}


def tables(found):
    return {
        "quantities": latex.quantities_tex(found, "a_study"),
        "features": latex.features_tex(found, "a_study"),
        "exponents": latex.exponents_tex(found, "a_study"),
        "models": latex.models_tex(found, NAMES, "a_study"),
        "verification": latex.verification_tex(found, PARTS, "a_study"),
    }


def test_every_macro_agrees_with_the_place_it_names():
    found = results()
    text = latex.numbers_tex(latex.study_numbers(found), "a_study")
    defined = macros(text)
    assert len(defined) == text.count(r"\newcommand") > 60
    assert len({name for name, _, _ in defined}) == len(defined)
    for _, value, source in defined:
        assert_agree(value, at_source(found, source))


@pytest.mark.parametrize("name", ["quantities", "features", "models", "verification"])
def test_every_number_in_a_table_agrees_with_the_place_it_names(name):
    found = results()
    checked = 0
    for cells, sources in rows(tables(found)[name]):
        numbers = [cell for cell in cells if is_number(cell)]
        assert len(numbers) == len(sources)
        for cell, source in zip(numbers, sources, strict=True):
            assert_agree(cell, at_source(found, source))
            checked += 1
    assert checked >= 4


def test_a_number_that_was_changed_is_noticed():
    with pytest.raises(AssertionError):
        assert_agree("0.61", 0.604)
    with pytest.raises(AssertionError):
        assert_agree(r"\ensuremath{6.51\times10^{-6}}", 6.53e-6)


def test_every_quantity_has_its_symbol_unit_and_range():
    text = tables(results())["quantities"]
    lines = [line for line in text.splitlines() if re.match(r"X\d+ &", line)]
    assert len(lines) == 21
    assert r"X21 & $\dot h$ & wear depth rate, total, mean over the plate & mm/s" in lines[-1]
    angle = next(line for line in lines if line.startswith("X13 "))
    assert angle.startswith(r"X13 & $\varphi$ & plate angle & \textdegree & 0 & 70")
    assert sum(" % " in line for line in lines) == 14
    derived = [line for line in lines if "%" not in line]
    assert all("$" in line.split(" & ")[-1] for line in derived[:-1])


def test_tables_have_as_many_cells_as_columns_and_escape_words():
    for text in tables(results()).values():
        head, *_ = (line for line in text.splitlines() if line.endswith(r"\\"))
        for cells, _ in rows(text):
            assert len(cells) == head.count(" & ") + 1
        assert text.count(r"\toprule") == text.count(r"\bottomrule") == 1
    assert r"Time step \& more & 1 & 1" in tables(results())["verification"]


def test_without_verification_and_simulations_these_numbers_are_left_out():
    found = results()
    files = {name: data for name, data in found.files.items() if name != latex.CHECKS}
    files[latex.SUMMARY] = {
        "external": "t.csv",
        "cases": 13,
        "target": "wear_total_mean",
        "target_words": "wear depth rate",
    }
    small = latex.CitedResults(files)
    names = set(latex.study_numbers(small))
    assert "NumberOfCases" in names and "RsquaredLinear" in names
    assert not {"VerificationChecks", "NumberOfFailures", "PlateLengthMm"} & names
    assert not list(rows(latex.verification_tex(small, PARTS, "x")))


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (200, "d", "200"),
        (-0.0004, "2f", "0.00"),
        (-0.245, "2f", r"\ensuremath{-0.24}"),
        (0.010048, "3s", "0.0100"),
        (200.0, "3s", "200"),
        (6.5056e-6, "3s", r"\ensuremath{6.51\times10^{-6}}"),
        (-123456.7, "2f", r"\ensuremath{-1.2\times10^{5}}"),
        (-1.2e31, "2r", r"below \ensuremath{-100}"),
        (-0.245, "2r", r"\ensuremath{-0.24}"),
        (1e300, "3s", r"above \ensuremath{1\times10^{15}}"),
        (math.inf, "3s", "not determined"),
        (1e-10, "4g", r"\ensuremath{1\times10^{-10}}"),
        (2000.0, "4g", "2000"),
        (math.nan, "2f", "not determined"),
        (None, "d", "not determined"),
        ([361, 12], "d", "361-12"),
        ("fixed_split & 5 %", "text", r"fixed\_split \& 5 \%"),
    ],
)
def test_numbers_are_printed_as_latex(value, form, text):
    assert latex.printed(value, form) == text
    if isinstance(value, float) and math.isfinite(value):
        assert_agree(text, value)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("wear where model=x", "there is no column 'model'"),
        ("nothing", "there is no column 'nothing'"),
        ("plate_angle", "12 rows, expected one"),
        ("biggest plate_angle", "'biggest' is not one of"),
    ],
)
def test_a_place_that_is_not_there_is_one_line(place, message):
    with pytest.raises(latex.PlaceError, match=message):
        results().value(latex.DATASET, place)
    with pytest.raises(latex.PlaceError, match="there is no 'plots'"):
        results().value(latex.CONFIG, "figures.plots.0")


def test_a_macro_holds_letters_only():
    with pytest.raises(ValueError, match="letters only"):
        latex.numbers_tex({"R2": latex.Number("1", "a", "b")}, "x")
    assert latex.camel("paper_net") == "PaperNet"


def written(folder):
    found = results()
    (folder / "latex").mkdir(parents=True)
    texts = {"numbers": latex.numbers_tex(latex.study_numbers(found), "a_study"), **tables(found)}
    for name, text in texts.items():
        (folder / "latex" / f"{name}.tex").write_text(text)
    return folder


def test_the_example_text_cites_only_numbers_that_there_are():
    text = (ROOT / "paper" / "main.tex").read_text(encoding="utf-8")
    cited = set(re.findall(r"\\([A-Z][A-Za-z]+)", text))
    known = set(latex.study_numbers(results())) | {"IfFileExists"}
    assert cited <= known


@pytest.mark.skipif(find_program() is None, reason="no LaTeX is installed")
def test_the_example_text_is_typeset(tmp_path):
    study = written(tmp_path / "a study")
    typeset(ROOT / "paper" / "main.tex", study, tmp_path / "out.pdf")
    assert (tmp_path / "out.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.skipif(find_program() is None, reason="no LaTeX is installed")
def test_a_text_with_a_mistake_is_one_line(tmp_path):
    (tmp_path / "bad.tex").write_text(
        "\\documentclass{article}\\begin{document}\\nothing\\end{document}\n"
    )
    with pytest.raises(TypesetError, match=r"bad\.tex: \w+ stopped: ") as error:
        typeset(tmp_path / "bad.tex", tmp_path, tmp_path / "out.pdf")
    assert "\n" not in str(error.value)
    assert not (tmp_path / "out.pdf").exists()


def test_without_latex_the_answer_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(TypesetError, match="no LaTeX is installed") as error:
        typeset("paper/main.tex", tmp_path, tmp_path / "out.pdf")
    assert "\n" not in str(error.value) and all(name in str(error.value) for name in PROGRAMS)
