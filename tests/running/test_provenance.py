"""Provenance of a run: versions, commit, environment, configuration."""

import json
import subprocess

from abradem.running import provenance


def test_provenance_is_the_same_bytes_every_time(tmp_path):
    recorded = {"seed": 1, "versions": provenance.versions()}
    for name in ("a", "b"):
        provenance.write_provenance(
            "study: x\n", recorded, tmp_path / name / "config.yaml", tmp_path / name / "v.json"
        )
    for file in ("config.yaml", "v.json"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    assert json.loads((tmp_path / "a" / "v.json").read_text())["versions"]["numpy"]


def test_provenance_names_commit_system_and_every_package(tmp_path):
    provenance.write_provenance("a: 1\n", {}, tmp_path / "config.yaml", tmp_path / "v.json")
    found = json.loads((tmp_path / "v.json").read_text())
    packages = found["environment"]["packages"]
    assert {"numba", "llvmlite", "numpy", "snakemake"} <= packages.keys()
    assert packages["numpy"] == provenance.versions()["numpy"]
    assert found["environment"]["machine"] and found["environment"]["system"]


def test_the_commit_is_that_of_the_repository_around_the_package(tmp_path, monkeypatch):
    package = tmp_path / "src" / "abradem"
    package.mkdir(parents=True)
    monkeypatch.setattr(provenance.abradem, "__path__", [str(package)])
    assert provenance.source() is None

    def git(*words):
        names = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
        command = ["git", "-C", str(tmp_path), *names, *words]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    git("init")
    assert provenance.source() is None  # No commit yet.
    (package / "a.py").write_text("1\n")
    git("add", "-A")
    git("commit", "-m", "first")
    assert provenance.source() == {"commit": git("rev-parse", "HEAD"), "changed": False}
    (package / "a.py").write_text("2\n")
    assert provenance.source()["changed"] is True
    monkeypatch.setenv("PATH", "")
    assert provenance.source() is None
