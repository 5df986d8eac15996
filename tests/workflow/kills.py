"""Kill a running study at random moments, resume it, compare: python tests/workflow/kills.py 50

In each test a small study is started, killed with SIGKILL, and resumed with the same command. Then
every table of the study must have the same bytes as in an undisturbed run, and no other files may
be left. There are several kinds of tests:

- anywhere: kill all processes at a random moment of the run;
- table: kill while a table is being written;
- compile: kill while kernels are being compiled, with an empty cache of kernels;
- report: kill while the report is being written;
- orphans: kill only Snakemake, so that its jobs continue and meet those of the second run;
- twice: kill nothing, but start two runs at the same time, one of which must stop;
- cores: kill nothing, but use one core and other jobs; only the joined tables are compared.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
TABLES = ("cases", "series", "maps", "parts", "runs", "wear_rates", "cases.parquet",
          "failures.parquet", "dataset.parquet")  # fmt: skip
SECONDS = 1800
"""Longest that a run may take, on the busiest machine."""

KINDS = ("anywhere", "table", "orphans", "twice", "cores", "compile", "report")

STUDY = {
    "sampling": {
        "blocks": 1,
        "cases_per_block": 6,
        "ranges": {"particle_radius_mm": [20, 40]},
    },
    "simulation": {
        "cases_per_job": 3,
        "plate": {"facet_size_mm": 30},
        "stop": {"window_s": 1, "max_time_s": 3, "target_stderr": 0.1},
        "max_failed_share": 1.0,
    },
    "figures": {"series_cases": [0]},
}


class Study:
    """A small study in its own folder, with the workflow of this checkout."""

    def __init__(self, folder: Path, name: str):
        self.folder, self.name, self.cores = folder, name, 2
        self.results = folder / "results" / name
        self.environment = dict(os.environ)
        for file in ("Snakefile", "config.yaml"):
            shutil.copy2(ROOT / file, folder)
        for tree in ("workflow", "profiles", "studies"):
            shutil.copytree(ROOT / tree, folder / tree, dirs_exist_ok=True)
        self.configure(STUDY)

    def configure(self, values: dict) -> None:
        path = self.folder / f"{self.name}.yaml"
        path.write_text(yaml.safe_dump({"study": self.name, **values}))

    def command(self, *arguments: str) -> list[str]:
        return [
            sys.executable, "-m", "snakemake", *arguments, "--cores", str(self.cores),
            "--configfile", "config.yaml", f"{self.name}.yaml",
        ]  # fmt: skip

    def start(self, *arguments: str) -> subprocess.Popen:
        """Start a run as the leader of its own process group."""
        return subprocess.Popen(
            self.command(*(arguments or ("dataset",))),
            cwd=self.folder, env=self.environment, start_new_session=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip

    def finish(self, *arguments: str) -> None:
        """Run to the end."""
        run = self.start(*arguments)
        try:
            said, _ = run.communicate(timeout=SECONDS)
        except subprocess.TimeoutExpired:
            kill(run)
            raise AssertionError(f"{self.name}: has not ended in {SECONDS} s") from None
        if run.returncode:
            raise AssertionError(f"{self.name}: could not be finished:\n{said}")

    def content(self) -> dict[str, bytes]:
        """Bytes of every table by its path."""
        found = {}
        for name in TABLES:
            path = self.results / name
            for file in sorted(path.glob("*")) if path.is_dir() else [path]:
                found[str(file.relative_to(self.results))] = file.read_bytes()
        return found

    def remains(self) -> list[str]:
        """Files that are neither results nor logs, such as temporary or incomplete ones."""
        return [str(path.relative_to(self.results)) for path in self.results.rglob(".*")]


def kill(run: subprocess.Popen, group: bool = True) -> None:
    """End a run, or Snakemake alone, at once."""
    (os.killpg if group else os.kill)(run.pid, signal.SIGKILL)
    run.communicate() if group else run.wait()


def wait_for(run: subprocess.Popen, happened, seconds: float = 300.0) -> None:
    """Check as often as possible whether something has happened, until the run ends."""
    end = time.monotonic() + seconds
    while not happened() and run.poll() is None and time.monotonic() < end:
        time.sleep(0.0005)


def disturb(study: Study, kind: str, chance: random.Random, duration: float) -> None:
    """Begin the study and kill it."""
    if kind == "twice":
        runs = [study.start(), study.start()]
        said = [run.communicate(timeout=SECONDS)[0] for run in runs]
        codes = [run.returncode for run in runs]
        assert 0 in codes, said
        for code, text in zip(codes, said, strict=True):
            assert code == 0 or "is at work here; wait for its end" in text, text
        return
    if kind == "cores":
        study.cores = 1
        study.configure({**STUDY, "simulation": {**STUDY["simulation"], "cases_per_job": 2}})
        return
    run = study.start()
    if kind == "table":
        written = chance.randrange(12)
        seen = set()

        def happened():
            seen.update(study.results.rglob(".*.tmp"))
            return len(seen) > written

        wait_for(run, happened)
    elif kind == "compile":
        cache = Path(study.environment["ABRADEM_CACHE_DIR"])
        wait_for(run, lambda: next(cache.rglob("*.nb*"), None))
        time.sleep(chance.uniform(0.0, 10.0))
    elif kind == "orphans":
        wait_for(run, lambda: next(study.results.glob(".finished/*/started"), None))
        time.sleep(chance.uniform(0.0, 2.0))
    else:
        time.sleep(chance.uniform(0.0, duration))
    kill(run, group=kind != "orphans")


def one_kill(
    folder: Path, kind: str, number: int, expected: dict[str, bytes], duration: float
) -> None:
    """Disturb a study, resume it, and compare; raises AssertionError if something differs."""
    chance = random.Random(f"{kind} {number}")
    folder.mkdir()
    try:
        study = Study(folder, "killed")
        if kind == "compile":
            study.environment |= {"ABRADEM_CACHE_DIR": str(folder / "cache"), "NUMBA_OPT": "1"}
        disturb(study, kind, chance, duration)
        study.finish()
        found = study.content()
        if kind == "cores":
            found, expected = (
                {name: data for name, data in content.items() if "batch" not in name}
                for content in (found, expected)
            )
        differing = [name for name in expected if found.get(name) != expected[name]]
        assert not differing, f"{kind} {number}: other bytes in {differing}"
        assert found.keys() == expected.keys(), f"{kind} {number}: {set(found) ^ set(expected)}"
        assert not study.remains(), f"{kind} {number}: left {study.remains()}"
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def kill_of_the_report(study: Study, number: int) -> None:
    """Kill the writing of the report of a whole study, then write it as the Makefile does."""
    chance = random.Random(f"report {number}")
    expected = study.content()
    part, report = study.results / ".report.html", study.results / "report.html"
    arguments = ("--report", str(part.relative_to(study.folder)))
    report.unlink(missing_ok=True)
    run = study.start(*arguments)
    time.sleep(chance.uniform(0.0, 10.0))
    kill(run)
    assert not report.exists()
    study.finish(*arguments)
    os.replace(part, report)
    assert report.read_text(encoding="utf-8").rstrip().endswith("</html>")
    assert study.content() == expected and not study.remains()


def whole(folder: Path) -> Study:
    """The smoke study with models and figures, as required for a report."""
    folder.mkdir()
    study = Study(folder, "killed")
    smoke = yaml.safe_load((ROOT / "studies/smoke.yaml").read_text(encoding="utf-8"))
    study.configure({**smoke, "study": study.name})
    study.finish("all")
    return study


def undisturbed(folder: Path) -> tuple[dict[str, bytes], float]:
    """Tables of an undisturbed study, and its run time, s."""
    folder.mkdir()
    study = Study(folder, "killed")
    began = time.monotonic()
    study.finish()
    return study.content(), time.monotonic() - began


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kills", type=int, nargs="?", default=50)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=None)
    options = parser.parse_args()
    # Compilation takes the longest.
    kinds = options.kinds or [
        *["anywhere"] * 4, *["table"] * 3, "orphans", "report", "compile",
    ]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        expected, duration = undisturbed(Path(folder, "undisturbed"))
        print(f"undisturbed: {duration:.1f} s, {len(expected)} tables", flush=True)
        reported = whole(Path(folder, "whole")) if "report" in kinds else None
        same = 0
        for number in range(options.kills):
            kind = kinds[number % len(kinds)]
            try:
                if kind == "report":
                    kill_of_the_report(reported, number)
                else:
                    one_kill(Path(folder, "killed"), kind, number, expected, duration)
            except AssertionError as error:
                print(f"{number + 1}: {error}", flush=True)
            else:
                same += 1
                print(f"{number + 1}: {kind}: same bytes", flush=True)
        print(f"{same} of {options.kills} kills ended in the same bytes")
    return 0 if same == options.kills else 1


if __name__ == "__main__":
    sys.exit(main())
