"""The Slurm profile, and the messages of the demonstration if it cannot run."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import psutil
import pytest
import yaml

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "profiles" / "slurm" / "demo.py"


def profile(name):
    return yaml.safe_load((ROOT / "profiles" / name / "config.yaml").read_text(encoding="utf-8"))


@pytest.fixture
def demo():
    spec = importlib.util.spec_from_file_location("slurm_demo", DEMO)
    module = importlib.util.module_from_spec(spec)
    # Its dataclasses look up their module there.
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def test_on_a_cluster_a_study_reruns_what_it_would_rerun_here():
    here, there = profile("default"), profile("slurm")
    del here["cores"], here["quiet"]
    assert here == {key: there[key] for key in here}


def test_the_profile_submits_every_job_with_memory_and_a_time_limit(tmp_path):
    pytest.importorskip("snakemake_executor_plugin_slurm")
    for name in ("Snakefile", "config.yaml"):
        shutil.copy2(ROOT / name, tmp_path)
    for name in ("studies", "workflow", "profiles"):
        shutil.copytree(ROOT / name, tmp_path / name)
    done = subprocess.run(
        [
            sys.executable, "-m", "snakemake", "--workflow-profile", "slurm", "--dry-run",
            "--quiet", "host", "--configfile", "config.yaml", "studies/smoke.yaml",
        ],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT / "src")}, text=True, check=False,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    jobs = re.findall(r"^rule (\w+):\n((?:    .*\n)+)", done.stdout, re.MULTILINE)
    asked = {rule: set() for rule, _ in jobs}
    for rule, job in jobs:
        asked[rule].update(re.findall(r"\bmem_mb=(\d+).*\bruntime=(\d+)", job) or [None])
    assert asked["table"] == {("1500", "30")}
    assert asked["simulate"] == {("1500", "183")}
    assert asked["fit_physical"] == {("4000", "240")}
    # A population of 4 uses 4 cores.
    assert asked["ga_ann"] == {("3500", "240")}
    assert all(None not in resources for resources in asked.values())


def test_without_slurm_the_demonstration_is_one_line(demo, monkeypatch, capsys):
    monkeypatch.delenv("SLURM_CONF", raising=False)
    monkeypatch.setattr(demo, "CONFIGURATIONS", ())
    monkeypatch.setattr(demo, "program", lambda name: None)
    monkeypatch.setattr(sys, "argv", ["demo.py"])
    assert demo.main() == 0
    printed = capsys.readouterr().out
    assert printed.startswith("slurm-demo skipped: no Slurm is installed here: munged, ")
    assert len(printed.splitlines()) == 1


def test_a_slurm_that_is_set_up_is_left_alone(demo, monkeypatch, tmp_path):
    monkeypatch.delenv("SLURM_CONF", raising=False)
    monkeypatch.setattr(demo, "program", lambda name: f"/usr/bin/{name}")
    configuration = tmp_path / "slurm.conf"
    monkeypatch.setattr(demo, "CONFIGURATIONS", (configuration,))
    assert "is set up here" not in (demo.why_not() or "")
    configuration.touch()
    assert demo.why_not().startswith(f"a Slurm is set up here ({configuration}): ")
    done = subprocess.run(
        [sys.executable, DEMO], env={**os.environ, "SLURM_CONF": "/somewhere/slurm.conf"},
        text=True, capture_output=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 0 and done.stderr == ""
    assert done.stdout == (
        "slurm-demo skipped: a Slurm is set up here (SLURM_CONF=/somewhere/slurm.conf): "
        "run the study on it, see docs/cluster.md\n"
    )


def test_only_processes_of_the_demonstration_are_ended(demo, tmp_path):
    cluster = demo.Cluster(tmp_path)

    def sleeper(**environment):
        return subprocess.Popen(["sleep", "60"], env={**os.environ, **environment})

    started = [
        sleeper(),
        sleeper(**{demo.MARK: "/another"}),
        sleeper(**{demo.MARK: str(tmp_path), demo.NODE_VARIABLE: "n1"}),
        sleeper(**{demo.MARK: str(tmp_path), demo.NODE_VARIABLE: "n2"}),
    ]
    try:
        cluster.kill_node("n2")
        assert started[3].wait(10) != 0
        assert [process.poll() for process in started[:3]] == [None] * 3
        cluster.stop()
        assert started[2].wait(10) != 0
        assert [process.poll() for process in started[:2]] == [None] * 2
        assert cluster.processes() == []
    finally:
        for process in started:
            process.kill()
            process.wait()


def test_memory_of_a_job_is_that_of_all_its_processes(demo, tmp_path):
    cluster, memory = demo.Cluster(tmp_path), demo.Memory()
    environment = {**os.environ, demo.MARK: str(tmp_path), "SLURM_JOB_ID": "7"}
    started = [subprocess.Popen(["sleep", "60"], env=environment) for _ in range(2)]
    try:
        memory.look(cluster)
        sizes = [psutil.Process(process.pid).memory_info().rss / 2**20 for process in started]
        assert memory.most_mb == {"7": pytest.approx(sum(sizes), rel=0.5)}
    finally:
        for process in started:
            process.kill()
            process.wait()


@pytest.mark.parametrize(("text", "size"), [("1500M", 1500), ("4G", 4096), ("512K", 0.5)])
def test_memory_is_read_as_slurm_prints_it(demo, text, size):
    assert demo.megabytes(text) == size
