"""Damage of any kind of result is found, named and healed by one command."""

import json
import os
import shutil
import struct
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from abradem.cli.main import main
from abradem.figures.style import save
from abradem.running.outputs import job_of, record_outputs
from abradem.running.soundness import CHECKS, examine, fault_of_format
from abradem.store.checksums import damage, record_path, recorded, remedy, study_of
from abradem.store.files import write_arrays, write_csv, write_json, write_text
from abradem.store.locks import lock_of_study
from abradem.store.tables import write_table


def box(kind, content=b""):
    return struct.pack(">I4s", 8 + len(content), kind) + content


def make(study):
    """One file of each format; they are the outputs of four jobs."""
    write_table(pd.DataFrame({"time": np.arange(300.0)}), study / "dataset.parquet")
    write_json({"a": [1, 2, 3], "b": "text"}, study / "learning" / "linear.json")
    write_arrays({"a": np.arange(50.0)}, study / "learning" / "linear.safetensors")
    write_csv(pd.DataFrame({"a": ["x, y", "z"], "b": [1, 2]}), study / "tables" / "scores.csv")
    figure = Figure()
    figure.subplots().plot([1, 2])
    (study / "figures").mkdir()
    save(figure, study / "figures" / "maps", ["png", "pdf", "svg"])
    tabular = "\\begin{tabular}{l}\nx\n\\end{tabular}\n"
    write_text(tabular, study / "latex" / "models.tex")
    write_text("<html>\n<p>x</p>\n</html>\n", study / "models" / "findings.html")
    write_text("study: a\nseed: 1\n", study / "config.yaml")
    write_text("# Data\n", study / "publish" / "README.md")
    film = box(b"ftyp", b"isom") + box(b"moov", b"x" * 40) + box(b"mdat", b"y" * 80)
    (study / "movie").mkdir()
    (study / "movie" / "wear.mp4").write_bytes(film)
    for name in ("particles_0.vtp", "particles_1.vtp", "plate.pvd"):
        write_text("<VTKFile>\n<P/>\n</VTKFile>\n", study / "vtk" / "typical" / name)
    write_json({"cases": 3}, study / "runs" / "a.json")
    write_text("s\th:m:s\n2.5\t0:00:02\n", study / "benchmarks" / "simulate" / "a.tsv")


JOBS = {
    "dataset": ["dataset.parquet"],
    "linear": ["learning/linear.json", "learning/linear.safetensors"],
    "figure_maps": ["figures/maps.png", "figures/maps.pdf", "figures/maps.svg"],
    "vtk/typical": ["vtk/typical"],
    "simulate/a": ["runs/a.json"],
    "others": ["tables/scores.csv", "latex/models.tex", "models/findings.html", "config.yaml",
               "publish/README.md", "movie/wear.mp4"],
}  # fmt: skip
FILES = [
    *(name for job, names in JOBS.items() if job != "vtk/typical" for name in names),
    "vtk/typical/particles_0.vtp", "vtk/typical/particles_1.vtp", "vtk/typical/plate.pvd",
]  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A study whose jobs recorded all files but the benchmark, which Snakemake writes."""
    folder = tmp_path_factory.mktemp("made") / "results" / "a"
    make(folder)
    for job, names in JOBS.items():
        record_outputs(folder, job, [folder / name for name in names])
    return folder


@pytest.fixture
def study(made, tmp_path, monkeypatch):
    """A copy of the study in the folder of the test."""
    monkeypatch.chdir(tmp_path)
    return shutil.copytree(made, Path("results", "a"))


def flip(path):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def cut(path):
    path.write_bytes(path.read_bytes()[:-7])


def empty(path):
    path.write_bytes(b"")


DAMAGES = {
    flip: "damaged, differs from what its job wrote",
    cut: "truncated, has",
    empty: "truncated, has 0 of",
    Path.unlink: "missing",
    lambda path: path.write_bytes(path.read_bytes() + b"\0"): "damaged, has",
}


def doctor(capsys, *arguments):
    code = main(["doctor", *map(str, arguments)])
    said = capsys.readouterr()
    assert said.err == "" or code == 2
    return code, said.out.splitlines() or said.err.splitlines()


def test_a_sound_study_is_said_to_be_sound(study, capsys):
    code, lines = doctor(capsys, study)
    assert code == 0
    assert lines == [
        f"results/a: all {len(FILES) + 1} files are sound (1 without a checksum, only parsed)"
    ]


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("harm", DAMAGES, ids=["flip", "cut", "empty", "missing", "longer"])
def test_damage_of_every_kind_of_file_is_found_and_its_remedy_named(study, capsys, name, harm):
    harm(study / name)
    code, lines = doctor(capsys, study)
    assert code == 1 and len(lines) == 3
    target = "vtk/typical" if name.startswith("vtk") else name
    options = "FILES-OF-THE-STUDY" if name == "config.yaml" else "results/a/config.yaml"
    command = f"snakemake --configfile {options} --force results/a/{target}"
    assert lines[0].startswith(f"results/a/{name}: {DAMAGES[harm]}")
    assert lines[0].endswith(f"; {command}")
    assert lines[1].startswith(f"results/a: 1 of {len(FILES) + 1} files are not sound")
    assert lines[2] == f"all are made again by: {command}"
    if harm is not Path.unlink:
        # What a job that reads the file ends with.
        assert damage(study / name) == (
            f"results/a/{name}: {lines[0].split(': ', 1)[1].split(';')[0]}; "
            "`abradem doctor results/a --delete` removes what is damaged, and the next run makes "
            "it again"
        )


def test_a_record_that_is_damaged_itself_does_not_hide_damage(study, capsys):
    for content in (b"", b"{}", b"\xff", b"[1]", b'{"sha256": 1}', b"[" * 100_000):
        record_path(study, "dataset.parquet").write_bytes(content)
        code, lines = doctor(capsys, study)
        assert code == 1 and "its record results/a/checksums/dataset.parquet.sha256 is" in lines[0]


def test_what_is_damaged_is_deleted_with_all_that_its_job_wrote(study, capsys):
    """Snakemake would not miss a file that nothing reads, such as the arrays of a model."""
    flip(study / "learning" / "linear.safetensors")
    cut(study / "vtk" / "typical" / "plate.pvd")
    (study / "figures" / "maps.svg").unlink()
    before = {path for path in study.rglob("*") if path.is_file()}
    code, lines = doctor(capsys, study, "--delete")
    assert code == 1
    removed = before - {path for path in study.rglob("*") if path.is_file()}
    assert {path.relative_to(study).as_posix() for path in removed} == {
        *JOBS["linear"], "vtk/typical/particles_0.vtp", "vtk/typical/particles_1.vtp",
        "vtk/typical/plate.pvd",
    }  # fmt: skip
    assert any(line.endswith("; removed with 1 other files of its job") for line in lines)
    assert any("maps.svg: missing; the next run makes it" in line for line in lines)
    assert "results/a/vtk/typical" in lines[-1] and "--force" in lines[-1]
    # Until they are made again they are missing, and nothing else is removed.
    code, lines = doctor(capsys, study, "--delete")
    assert code == 1 and all(": missing; " in line for line in lines[:-2])
    assert removed == before - {path for path in study.rglob("*") if path.is_file()}


def test_a_file_made_again_is_sound_again(study, capsys):
    flip(study / "dataset.parquet")
    assert doctor(capsys, study)[0] == 1
    write_table(pd.DataFrame({"time": np.arange(7.0)}), study / "dataset.parquet")
    record_outputs(study, "dataset", [study / "dataset.parquet"])
    assert doctor(capsys, study)[0] == 0


def test_a_folder_made_again_with_fewer_files_misses_none(study, capsys):
    (study / "vtk" / "typical" / "particles_1.vtp").unlink()
    assert doctor(capsys, study)[0] == 1
    record_outputs(study, "vtk/typical", [study / "vtk" / "typical"])
    assert doctor(capsys, study)[0] == 0


def test_files_of_a_folder_are_made_by_an_output_that_the_rule_names(study):
    """As the published folder, of which the rule names three files."""
    write_text("x\n", study / "publish" / "data" / "a.csv")
    record_outputs(study, "publish", [study / "publish" / "README.md"], [study / "publish"])
    cut(study / "publish" / "data" / "a.csv")
    (finding,) = examine(study).findings
    assert finding.name == "publish/data/a.csv" and finding.target == "publish/README.md"


def test_studies_that_grow_or_run_at_once_share_no_record(study, capsys):
    other = Path("results", "b")
    shutil.copytree(study, other)
    flip(other / "dataset.parquet")
    before = {path: path.read_bytes() for path in study.rglob("*") if path.is_file()}
    write_table(pd.DataFrame({"time": [1.0]}), other / "cases" / "block-001.parquet")
    record_outputs(other, "sample/block-001", [other / "cases" / "block-001.parquet"])
    assert before == {path: path.read_bytes() for path in study.rglob("*") if path.is_file()}
    assert doctor(capsys, study)[0] == 0 and doctor(capsys, other)[0] == 1
    assert set(recorded(other)) - set(recorded(study)) == {"cases/block-001.parquet"}


def test_equal_files_have_equal_records(study, tmp_path):
    again = tmp_path / "again" / "results" / "a"
    make(again)
    for job, names in JOBS.items():
        record_outputs(again, job, [again / name for name in names])
    for name in FILES:
        # The film, the tables and the texts; the time is in none of them.
        assert record_path(again, name).read_bytes() == record_path(study, name).read_bytes()


def test_while_a_run_is_at_work_the_doctor_waits_for_its_end(study, capsys):
    lock = lock_of_study("a")
    assert lock.take()
    code, lines = doctor(capsys, study, "--delete")
    assert code == 2 and lines == [f"results/a: {lock.holder()} is at work here; wait for its end"]
    lock.release()
    assert doctor(capsys, study)[0] == 0


@pytest.mark.parametrize("name", ["results/none", "results/a/config.yaml"])
def test_what_is_no_folder_is_one_line(study, capsys, name):
    code, (line,) = doctor(capsys, name)
    assert code == 2 and line.startswith(f"{name}: there is no such folder")


@pytest.mark.parametrize(
    "name", [".", "/", "..", "/usr", "results", "results/empty", "results/bare", "data", "named"]
)
def test_what_is_no_study_is_one_line(study, capsys, name):
    Path("results/empty").mkdir()
    make(Path("results/bare"))
    # A user's own data beside checksums of another program, with a config.yaml of another program.
    for folder in ("data", "named"):
        write_text("a,b\n1", Path(folder, "mine.csv"))
        write_text(f"{'0' * 64}  mine.csv\n", record_path(Path(folder), "mine.csv"))
    write_text("study: mine\n", Path("named/config.yaml"))
    for options in ([], ["--delete"]):
        code, (line,) = doctor(capsys, name, *options)
        assert code == 2
        assert line.startswith(f"{name}: is not the folder of a study")
        assert line.endswith("; give one such as results/paper")
    assert Path("data/mine.csv").exists() and Path("named/mine.csv").exists()
    for path in (Path("data/mine.csv"), Path("named/mine.csv")):
        assert damage(path) is None and remedy(path) == "" and study_of(path) is None


@pytest.mark.parametrize("inside", ["models", "learning", "vtk/typical", "checksums", "benchmarks"])
def test_a_folder_in_a_study_is_one_line_that_names_the_study(study, capsys, monkeypatch, inside):
    code, (line,) = doctor(capsys, study / inside)
    assert code == 2 and line.endswith("; give results/a")
    monkeypatch.chdir(study)
    assert doctor(capsys, ".")[0] == 0


def test_records_without_a_study_have_no_remedy(study, capsys):
    """Their files are compared all the same; the log of a job stands for the configuration."""
    for name in ("config.yaml", "checksums/config.yaml.sha256"):
        (study / name).unlink()
    cut(study / "dataset.parquet")
    assert damage(study / "dataset.parquet").startswith("results/a/dataset.parquet: truncated")
    assert "doctor" not in damage(study / "dataset.parquet")
    assert doctor(capsys, study, "--delete")[0] == 2 and (study / "dataset.parquet").exists()
    write_text("", study / "logs" / "dataset.log")
    assert damage(study / "dataset.parquet").endswith("the next run makes it again")
    code, lines = doctor(capsys, study)
    assert code == 1 and lines[0].endswith("; snakemake --force results/a/dataset.parquet")


# Records that are no records of ours


def forged(study, name, **fields):
    """Change fields of the record of a file, which is made damaged."""
    path = record_path(study, name)
    write_json({**json.loads(path.read_text()), **fields}, path)
    cut(study / name)


def everything(folder):
    return {path: path.is_file() and path.read_bytes() for path in Path(folder).rglob("*")}


@pytest.mark.parametrize(
    "target",
    ["", ".", "./", "..", "../b", "../../precious", "learning/..", "learning/../..", "learning/.",
     "/", "ABSOLUTE", "a//b", "vtk/", "checksums", "checksums/dataset.parquet.sha256", "logs",
     "..\\b", "a\nb", "a\0b"],
)  # fmt: skip
def test_a_record_with_another_target_than_a_result_is_damaged(study, capsys, tmp_path, target):
    write_text("x\n", tmp_path / "precious" / "a.txt")
    write_text("x\n", tmp_path / "results" / "b" / "a.txt")
    named = str(tmp_path / "precious") if target == "ABSOLUTE" else target
    forged(study, "learning/linear.json", target=named)
    before = everything(tmp_path)
    for options in ([], ["--delete"]):
        code, lines = doctor(capsys, study, *options)
        assert code == 1
        assert "its record results/a/checksums/learning/linear.json.sha256 is damaged" in lines[0]
        assert lines[-1].endswith("--force results/a/learning/linear.json")
        assert everything(tmp_path) == before
    assert damage(study / "learning/linear.json").endswith(
        "; `abradem doctor results/a` names the command that makes both again"
    )


@pytest.mark.parametrize(
    "fields", [{"sha256": "f"}, {"sha256": "F" * 64}, {"size": -1}, {"job": ""}, {"size": True}]
)
def test_a_record_with_impossible_fields_is_damaged(study, capsys, fields):
    forged(study, "dataset.parquet", **fields)
    _, lines = doctor(capsys, study, "--delete")
    assert "its record" in lines[0] and (study / "dataset.parquet").exists()


@pytest.mark.parametrize("name", ["", "learning/", "checksums/a", "logs/a.log"])
def test_a_record_of_what_is_no_result_is_damaged(study, capsys, name):
    record = record_path(study, "dataset.parquet").read_text()
    write_text(record, study / "checksums" / f"{name}.sha256")
    before = everything(study)
    code, lines = doctor(capsys, study, "--delete")
    assert code == 1 and "its record" in lines[0] and everything(study) == before


def test_a_pipe_for_a_record_is_damaged(study, capsys):
    record_path(study, "dataset.parquet").unlink()
    os.mkfifo(record_path(study, "dataset.parquet"))
    code, lines = doctor(capsys, study, "--delete")
    assert code == 1 and "its record" in lines[0]


def test_a_target_of_other_files_removes_only_what_is_recorded_for_it(study, capsys):
    """The folder of a record is not emptied, nor what another job wrote there."""
    forged(study, "dataset.parquet", target="learning")
    before = set(everything(study))
    doctor(capsys, study, "--delete")
    assert before - set(everything(study)) == {study / "dataset.parquet"}


def test_files_of_the_user_in_the_folder_of_an_output_are_kept(study, capsys):
    write_text("mine", study / "vtk/typical/notes.md")
    write_text("", study / "vtk/typical/.snakemake_timestamp")
    cut(study / "vtk/typical/plate.pvd")
    _, lines = doctor(capsys, study, "--delete")
    assert lines[0].endswith(
        "; removed with 2 other files of its job; 1 files in its folder that no job wrote are kept"
    )
    assert [path.name for path in (study / "vtk/typical").iterdir()] == ["notes.md"]


def test_a_link_that_leads_out_of_the_study_is_not_followed(study, capsys, tmp_path):
    shutil.move(study / "learning", tmp_path / "elsewhere")
    (study / "learning").symlink_to(tmp_path / "elsewhere")
    cut(tmp_path / "elsewhere" / "linear.json")
    _, lines = doctor(capsys, study, "--delete")
    assert lines[0].endswith("; not removed, as a link leads out of the study")
    assert len(list((tmp_path / "elsewhere").iterdir())) == 2


def test_a_study_behind_a_link_is_a_study(study, capsys, tmp_path):
    shutil.move(study, tmp_path / "disk")
    study.symlink_to(tmp_path / "disk")
    cut(study / "dataset.parquet")
    _, lines = doctor(capsys, study, "--delete")
    assert lines[0].endswith("; removed") and not (tmp_path / "disk/dataset.parquet").exists()


@pytest.mark.parametrize("place", ["dataset.parquet", "mine.csv", "benchmarks/simulate/a.tsv"])
def test_a_pipe_for_a_result_is_no_file(study, capsys, place):
    (study / place).unlink(missing_ok=True)
    os.mkfifo(study / place)
    _, lines = doctor(capsys, study)
    assert any(place in line and "is no file" in line for line in lines)


# Files of the user


OWN = {
    "notes.md": "no final newline", "mine.csv": "a,b\n1\n", "models/mine.json": "{",
    "figures/mine.png": "", "benchmarks/mine.tsv": "a\tb\n1", "mine.docx": "x",
    "x/report.html": "x",
}  # fmt: skip


def test_files_of_the_user_are_listed_apart_and_left_alone(study, capsys):
    for name, text in OWN.items():
        write_text(text, study / name)
    before = everything(study)
    for options in ([], ["--delete"]):
        code, lines = doctor(capsys, study, *options)
        assert code == 0 and everything(study) == before
        assert len(lines) == len(OWN) + 1 and "snakemake" not in "".join(lines)
        for name in OWN:
            said = f"results/a/{name}: not written by a job of this study (no record)"
            assert any(line.startswith(said) for line in lines)
        assert lines[-1].startswith(f"results/a: all {len(FILES) + 1} files are sound")
    assert any(line.endswith("(no record); truncated, ends within a line") for line in lines)


def test_many_files_of_the_user_are_counted(study, capsys):
    for number in range(30):
        write_text("x\n", study / "mine" / f"{number}.md")
    code, lines = doctor(capsys, study)
    assert code == 0 and len(lines) == 22
    assert lines[20] == "results/a: 10 more files not written by a job of this study (no record)"


def test_many_damaged_files_are_healed_by_the_study_as_a_whole(study, capsys):
    for number in range(30):
        write_json({}, study / "runs" / f"{number}.json")
        record_outputs(study, f"simulate/{number}", [study / "runs" / f"{number}.json"])
        cut(study / "runs" / f"{number}.json")
    _, lines = doctor(capsys, study)
    assert lines[-1] == (
        "all are made again by: abradem doctor results/a --delete; "
        "snakemake --configfile results/a/config.yaml"
    )


def test_the_study_of_a_file_is_that_with_records(study, monkeypatch):
    assert study_of(study / "learning" / "linear.json") == study
    assert study_of((study / "learning" / "linear.json").absolute()) == study.absolute()
    assert study_of(Path("results/other/a.json")) is None
    monkeypatch.chdir(study / "learning")
    for name in ("linear.json", Path("../dataset.parquet")):
        assert study_of(name).resolve() == Path("..").resolve()
    assert damage("linear.json") is None


@pytest.mark.parametrize(
    ("log", "job"),
    [
        ("results/a/logs/linear.log", ("results/a", "linear")),
        ("x/results/a/logs/sample/block-000.log", ("x/results/a", "sample/block-000")),
        ("results/logs/logs/linear.log", ("results/logs", "linear")),
        ("job.log", None),
    ],
)
def test_a_job_has_the_name_of_its_log(log, job):
    found = job_of(log)
    assert (found and (str(found[0]), found[1])) == job


# Files without a record


UNRECORDED = [*FILES, "benchmarks/simulate/a.tsv"]


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """A study of a time before there were records."""
    folder = tmp_path_factory.mktemp("bare") / "results" / "a"
    make(folder)
    return folder


@pytest.mark.parametrize("name", UNRECORDED)
def test_without_records_what_is_cut_off_is_found(bare, name):
    path = bare / name
    whole = path.read_bytes()
    assert fault_of_format(path) is None
    try:
        for part in (whole[:-7], whole[: len(whole) // 2], b"", b"\0" * len(whole)):
            path.write_bytes(part)
            reason = fault_of_format(path)
            assert reason and "\n" not in reason
            assert (name, reason) in examine(bare).foreign
    finally:
        path.write_bytes(whole)
    assert {reason for _, reason in examine(bare).foreign} == {""}


def test_every_format_that_is_checked_is_tested():
    assert {Path(name).suffix for name in UNRECORDED} == set(CHECKS)


def test_every_chunk_of_a_png_is_compared_with_its_own_checksum(bare):
    path = bare / "figures" / "maps.png"
    whole = path.read_bytes()
    try:
        for place in range(8, len(whole), max(1, len(whole) // 50)):
            data = bytearray(whole)
            data[place] ^= 1
            path.write_bytes(data)
            assert fault_of_format(path), place
    finally:
        path.write_bytes(whole)


def test_rows_of_another_width_are_found(bare):
    path = bare / "tables" / "scores.csv"
    whole = path.read_bytes()
    try:
        path.write_text('a,b\n"x, y",1\nz\n')
        assert fault_of_format(path) == "damaged, row 2 has 1 fields and the header 2"
    finally:
        path.write_bytes(whole)


def test_a_report_is_made_again_by_its_own_command(study, capsys):
    (study / "report.html").write_text("<html>")
    code, lines = doctor(capsys, "results/a")
    assert code == 1
    assert lines[0].endswith(
        "; snakemake --configfile results/a/config.yaml --report results/a/report.html"
        " --report-stylesheet workflow/report/report.css"
    )


@pytest.mark.parametrize(
    ("benchmark", "job"), [("simulate/a", "simulate/a"), ("ga_ann/b", "ga_ann_b"), ("c", "c")]
)
def test_a_benchmark_is_measured_again_by_the_job_of_its_name(study, capsys, benchmark, job):
    """Snakemake makes no benchmark that is asked for alone; nothing else needs to be removed."""
    write_json({}, study / "runs" / "a.json")
    record_outputs(study, job, [study / "runs" / "a.json"])
    path = study / "benchmarks" / f"{benchmark}.tsv"
    path.parent.mkdir(exist_ok=True)
    path.write_text("s\th:m:s\n2.")
    _, (line, *_) = doctor(capsys, study)
    assert line.endswith("--force results/a/runs/a.json")
    doctor(capsys, study, "--delete")
    assert not path.exists() and (study / "runs" / "a.json").exists()
    assert doctor(capsys, study)[0] == 0


def test_hidden_files_and_logs_are_no_results(bare):
    for name in ("logs/linear.log", ".finished/a/x.json", "learning/.x.json.1.tmp"):
        (bare / name).parent.mkdir(parents=True, exist_ok=True)
        (bare / name).write_text("{")
    found = examine(bare)
    assert found.findings == []
    assert {name for name, _ in found.foreign} == set(UNRECORDED)
