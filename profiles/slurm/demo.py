"""Run a study on a temporary Slurm cluster on this machine: make slurm-demo.

A controller and two nodes (slurmd) run on the loopback interface from a temporary folder, with
their own key. The study runs on them with the profile in this folder. While jobs run on both
nodes, one node is killed with all its processes, including a simulation. Later a job on the other
node is cancelled. The study must complete nevertheless. The verdict is based on the records of the
Slurm controller for every job. Everything that was started is stopped at the end in any case.

The demonstration needs root and the Debian packages slurmctld, slurmd, munge, slurm-client and
slurm-wlm-basic-plugins. If they are missing, or if Slurm is already configured, it prints one line
and does nothing.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import importlib.util
import os
import re
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parents[2]
STUDY = "slurm_demo"
CONFIGURATIONS = (Path("/etc/slurm/slurm.conf"), Path("/etc/slurm-llnl/slurm.conf"))
PLUGIN = "snakemake_executor_plugin_slurm"
DAEMONS = ("munged", "slurmctld", "slurmd")
COMMANDS = ("sbatch", "srun", "squeue", "sinfo", "scontrol", "scancel", "sacct", "sacctmgr")
NODES = ("n1", "n2")
CORES, MEMORY_MB = 2, 16000
"""Resources that each node declares; Slurm does not check them."""

MARK = "ABRADEM_SLURM_DEMO"
"""Environment variable of all processes of the demonstration."""

NODE_VARIABLE = "SLURMD_NODENAME"
"""Environment variable of all processes on a node: set by Slurm for jobs, and here for daemons."""

CONFIGURATION = """\
ClusterName=demo
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=20
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SlurmdParameters=config_overrides
# Time until a dead node is noticed, s; finished jobs are kept for the whole demonstration.
SlurmdTimeout=20
MinJobAge=86400
KillWait=5
MessageTimeout=30
{nodes}
PartitionName=demo Nodes={names} Default=YES MaxTime=INFINITE State=UP
"""


class DemoError(Exception):
    """The demonstration cannot continue."""


def why_not() -> str | None:
    """The reason why the demonstration cannot run here, or None."""
    found = [str(path) for path in CONFIGURATIONS if path.exists()]
    if os.environ.get("SLURM_CONF"):
        found.append(f"SLURM_CONF={os.environ['SLURM_CONF']}")
    if found:
        return f"a Slurm is set up here ({found[0]}): run the study on it, see docs/cluster.md"
    missing = [name for name in (*DAEMONS, *COMMANDS) if program(name) is None]
    if missing:
        return f"no Slurm is installed here: {', '.join(missing)} not found"
    if importlib.util.find_spec(PLUGIN) is None:
        return 'snakemake-executor-plugin-slurm is not installed: pip install -e ".[slurm]"'
    if os.geteuid() != 0:
        return "the nodes of a Slurm must be started by root"
    return None


def program(name: str) -> str | None:
    """Path of a program; daemons may be in folders that are not on the user's path."""
    return shutil.which(name, path=f"{os.environ.get('PATH', os.defpath)}:/usr/sbin:/sbin")


def free_ports(count: int) -> list[int]:
    """Unused ports of the loopback interface."""
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def wait_for(met: Callable[[], bool], what: str, seconds: float) -> None:
    """Wait until ``met()`` is true.

    Raises
    ------
    DemoError
        If it is not true within ``seconds``.
    """
    end = time.monotonic() + seconds
    while not met():
        if time.monotonic() > end:
            raise DemoError(f"{what} took more than {seconds:.0f} s")
        time.sleep(0.5)


class Cluster:
    """A Slurm cluster of two nodes on this machine.

    Parameters
    ----------
    folder : Path
        Empty folder for configuration, key, sockets, state and logs.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self.configuration = folder / "slurm.conf"
        self.daemons: dict[str, subprocess.Popen] = {}
        # Snakemake and its executor drop SLURM_CONF from the environment. It is therefore set by
        # wrappers of the commands, which are first on the path. Nothing is written to /etc.
        self.environment = {
            **os.environ,
            MARK: str(folder),
            "PATH": f"{folder / 'bin'}:{Path(sys.executable).parent}:{os.environ['PATH']}",
        }

    def start(self) -> None:
        """Start all daemons and wait until the nodes accept jobs."""
        for name in ("bin", "state", *NODES):
            (self.folder / name).mkdir()
        for name in COMMANDS:
            path = self.folder / "bin" / name
            path.write_text(
                f'#!/bin/sh\nSLURM_CONF={self.configuration} exec {program(name)} "$@"\n'
            )
            path.chmod(0o755)
        key = self.folder / "munge.key"
        key.touch(mode=0o600)
        key.write_bytes(secrets.token_bytes(128))
        controller, *ports = free_ports(1 + len(NODES))
        nodes = (
            f"NodeName={name} NodeHostname=localhost NodeAddr=127.0.0.1 Port={port} "
            f"CPUs={CORES} RealMemory={MEMORY_MB} State=UNKNOWN"
            for name, port in zip(NODES, ports, strict=True)
        )
        self.configuration.write_text(
            CONFIGURATION.format(
                host=socket.gethostname().split(".")[0], folder=self.folder,
                controller=controller, nodes="\n".join(nodes), names=",".join(NODES),
            )
        )  # fmt: skip

        munge = [f"--{part}-file={self.folder}/munge.{part}" for part in ("key", "pid", "log")]
        self._daemon(
            "munged", "--foreground", "--force", *munge, f"--seed-file={self.folder}/munge.seed",
            f"--socket={self.folder}/munge.socket",
        )  # fmt: skip
        wait_for((self.folder / "munge.socket").exists, "munged", 30)
        self._daemon("slurmctld", "-D", "-c", "-f", str(self.configuration))
        for node in NODES:
            self._daemon("slurmd", "-D", "-N", node, "-f", str(self.configuration), node=node)
        wait_for(lambda: set(self.node_states().values()) == {"idle"}, "starting Slurm", 120)

    def _daemon(self, name: str, *arguments: str, node: str | None = None) -> None:
        with open(self.folder / f"{node or name}.out", "wb") as out:
            self.daemons[node or name] = subprocess.Popen(
                [program(name), *arguments],
                env={**self.environment, **({NODE_VARIABLE: node} if node else {})},
                stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT,
                start_new_session=True,
            )  # fmt: skip

    def command(self, *words: str) -> str:
        """Output of a Slurm command; empty if the controller does not answer."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            return subprocess.run(
                words, env=self.environment, capture_output=True, text=True, timeout=60, check=False
            ).stdout
        return ""

    def node_states(self) -> dict[str, str]:
        """State of each node, from sinfo."""
        lines = self.command("sinfo", "--noheader", "--Node", "--format=%N %t").splitlines()
        return dict(line.split() for line in lines)

    def jobs(self) -> list[dict[str, str]]:
        """All jobs submitted so far, with the fields of `scontrol show job`."""
        lines = self.command("scontrol", "show", "job", "--oneliner").splitlines()
        found = [dict(re.findall(r"(\S+?)=(\S*)", line)) for line in lines if "JobId=" in line]
        return [{**job, "Rule": rule_of(job)} for job in found]

    def processes(self, node: str | None = None) -> list[psutil.Process]:
        """All processes of this cluster or of one of its nodes, regardless of their parents."""
        return [process for process in psutil.process_iter() if self._owns(process, node)]

    def _owns(self, process: psutil.Process, node: str | None) -> bool:
        environment = environment_of(process)
        if environment.get(MARK) == str(self.folder):
            return node in (None, environment.get(NODE_VARIABLE))
        # Processes that supervise a job overwrite their environment with their title, but have
        # the log of their node open.
        with contextlib.suppress(psutil.Error, OSError):
            if process.name().startswith("slurmstepd"):
                logs = {
                    str(self.folder / f"{name}.log") for name in (NODES if not node else [node])
                }
                return any(file.path in logs for file in process.open_files())
        return False

    def kill_node(self, name: str) -> None:
        """Kill a node at once, with all processes on it."""
        doomed = self.processes(name)
        # Suspended first, so that no process can report the death of another.
        for end in (psutil.Process.suspend, psutil.Process.kill):
            for process in doomed:
                with contextlib.suppress(psutil.Error):
                    end(process)

    def stop(self) -> None:
        """End all processes of this cluster."""
        for end in (psutil.Process.terminate, psutil.Process.kill):
            for process in self.processes():
                with contextlib.suppress(psutil.Error):
                    end(process)
            with contextlib.suppress(DemoError):
                wait_for(lambda: not self.processes(), "stopping Slurm", 10)


def rule_of(job: dict[str, str]) -> str:
    """Rule of a job, from the comment that snakemake gives it."""
    return re.sub(r"^rule_|_wildcards_.*", "", job.get("Comment", ""))


def environment_of(process: psutil.Process) -> dict[str, str]:
    """Environment with which a process was started; empty if it cannot be read."""
    try:
        return process.environ()
    except (psutil.Error, OSError):
        return {}


class Memory:
    """Peak memory of each job: sum over its processes, with shared pages counted in each."""

    def __init__(self):
        self.most_mb: dict[str, float] = {}

    def look(self, cluster: Cluster) -> None:
        """Measure the jobs that are running now."""
        now: Counter = Counter()
        for process in cluster.processes():
            if job := environment_of(process).get("SLURM_JOB_ID"):
                with contextlib.suppress(psutil.Error):
                    now[job] += process.memory_info().rss / 2**20
        for job, megabytes in now.items():
            self.most_mb[job] = max(self.most_mb.get(job, 0.0), megabytes)


@dataclass
class Harm:
    """Disturbances of the cluster during the study: the node killed and the jobs affected."""

    node: str = ""
    killed: list[str] = field(default_factory=list)
    noticed: bool = False
    cancelled: list[str] = field(default_factory=list)


def harm(cluster: Cluster, done: Harm) -> Iterator[None]:
    """Kill a node, later cancel a job; yields whenever it has to wait."""
    while True:
        jobs = running(cluster)
        simulating = [job["NodeList"] for job in jobs if job["Rule"] == "simulate"]
        if simulating and {job["NodeList"] for job in jobs} == set(NODES):
            break
        yield
    done.node = simulating[0]
    done.killed = [job["JobId"] for job in jobs if job["NodeList"] == done.node]
    say(cluster.command("squeue", "--format=%.5i %.9T %.4N %.6M %.8m %.10l  %k").rstrip())
    cluster.kill_node(done.node)
    say(f"{done.node} killed, with jobs {', '.join(done.killed)}")
    while not cluster.node_states().get(done.node, "").startswith("down"):
        yield
    done.noticed = True
    say(f"noticed by the controller: {cluster.node_states()}")
    while not done.cancelled:
        yield
        jobs = sorted(running(cluster), key=lambda job: job["Rule"] != "simulate")
        for number in [job["JobId"] for job in jobs[:1]]:
            cluster.command("scancel", number)
            while (state := state_of(cluster, number)) in ("", "RUNNING", "COMPLETING"):
                yield
            # The job may have finished just before.
            if state == "CANCELLED":
                done.cancelled = [number]
    say(f"job {done.cancelled[0]} cancelled")


def running(cluster: Cluster) -> list[dict[str, str]]:
    """Jobs that are running now."""
    return [job for job in cluster.jobs() if job["JobState"] == "RUNNING"]


def state_of(cluster: Cluster, number: str) -> str:
    """State of a job; empty if the controller does not answer."""
    states = {job["JobId"]: job["JobState"] for job in cluster.jobs()}
    return states.get(number, "")


def say(text: str) -> None:
    """Print without buffering."""
    print(text, flush=True)


def snakemake(*arguments: str) -> list[str]:
    """Command that runs the study of the demonstration on Slurm."""
    return [
        sys.executable, "-m", "snakemake", *arguments,
        "--workflow-profile", "profiles/slurm", "--configfile", "config.yaml",
        "studies/smoke.yaml", "--config", f"study={STUDY}",
    ]  # fmt: skip


def demonstrate(cluster: Cluster, targets: list[str], minutes: float) -> bool:
    """Run the study, disturb the cluster meanwhile, and return whether all checks pass."""
    results = ROOT / "results" / STUDY
    shutil.rmtree(results, ignore_errors=True)
    log = results / "logs" / "slurm.log"
    log.parent.mkdir(parents=True)
    say(f"{STUDY}: starts, see {log.relative_to(ROOT)}")
    memory, done = Memory(), Harm()
    steps = harm(cluster, done)
    start = time.monotonic()
    with open(log, "wb") as out:
        run = subprocess.Popen(
            # All jobs are short, so their status is checked often.
            snakemake(
                *targets, "--slurm-status-command", "squeue",
                "--slurm-init-seconds-before-status-checks", "2", "--latency-wait", "10",
                "--cores", str(len(NODES) * CORES), "--max-threads", str(CORES),
            ),
            cwd=ROOT, env=cluster.environment, stdin=subprocess.DEVNULL, stdout=out,
            stderr=subprocess.STDOUT,
        )  # fmt: skip
        while run.poll() is None:
            if time.monotonic() - start > 60.0 * minutes:
                raise DemoError(f"the study took more than {minutes:g} minutes, see {log}")
            memory.look(cluster)
            next(steps, None)
            time.sleep(0.5)
    ended = "ended" if run.returncode == 0 else "failed"
    say(f"{STUDY}: {ended} after {time.monotonic() - start:.0f} s")
    jobs = cluster.jobs()
    table = results / "logs" / "slurm_jobs.csv"
    write_jobs(table, jobs, memory)
    say(f"{len(jobs)} jobs of Slurm, see {table.relative_to(ROOT)}")
    left = subprocess.run(
        snakemake(*targets, "--dry-run"), cwd=ROOT, env=cluster.environment, text=True,
        capture_output=True, check=False,
    )  # fmt: skip
    complete = (
        run.returncode == 0 and bool(jobs) and "Nothing to be done" in left.stdout + left.stderr
    )
    return verdict(jobs, memory, done, complete)


COLUMNS = (
    "JobId", "Rule", "Comment", "JobState", "NodeList", "Restarts", "SubmitTime", "StartTime",
    "EndTime", "TimeLimit", "MinMemoryNode",
)  # fmt: skip


def write_jobs(path: Path, jobs: list[dict[str, str]], memory: Memory) -> None:
    """Write a table of all jobs."""
    with open(path, "w", encoding="utf-8", newline="") as out:
        table = csv.writer(out)
        table.writerow([*COLUMNS, "MostMemoryMB"])
        for job in jobs:
            most = memory.most_mb.get(job["JobId"], 0.0)
            table.writerow([*(job.get(name, "") for name in COLUMNS), f"{most:.0f}"])


def verdict(jobs: list[dict[str, str]], memory: Memory, done: Harm, complete: bool) -> bool:
    """Print a summary of the jobs, and whether each expectation is met."""
    for node in NODES:
        states = Counter(job["JobState"].lower() for job in jobs if job["NodeList"] == node)
        counts = ", ".join(f"{count} {state}" for state, count in states.items())
        say(f"  {node}: {counts or 'nothing ended here'}")
    completed = {job["Comment"] for job in jobs if job["JobState"] == "COMPLETED"}
    requeued = {job["JobId"] for job in jobs if int(job.get("Restarts", 0)) > 0}
    again = [job for job in jobs if job["JobId"] in done.cancelled and job["Comment"] in completed]
    asked = {job["JobId"]: megabytes(job["MinMemoryNode"]) for job in jobs}
    used = {number: memory.most_mb.get(number, 0.0) / most for number, most in asked.items()}
    for job in sorted(jobs, key=lambda job: used[job["JobId"]])[-1:]:
        number = job["JobId"]
        say(
            f"  largest share of the requested memory: {memory.most_mb.get(number, 0.0):.0f} of "
            f"{asked[number]:.0f} MB, {job['Rule']}"
        )
    checks = {
        f"a node died while both ran jobs; jobs on it: {len(done.killed)}": done.noticed,
        f"requeued by Slurm: {len(requeued)}": bool(requeued & set(done.killed)),
        f"cancelled, and resubmitted by snakemake: {len(again)}": bool(again),
        "no job used more memory than it requested": all(share <= 1.0 for share in used.values()),
        "the study is complete": complete,
    }
    for what, met in checks.items():
        say(f"  {'yes' if met else 'NO '}  {what}")
    say(f"Slurm demonstration: {'passed' if all(checks.values()) else 'FAILED'}")
    return all(checks.values())


def megabytes(text: str) -> float:
    """Memory in MB from the format of scontrol, such as 1500M or 2G."""
    units = {"K": 2.0**-10, "M": 1.0, "G": 2.0**10, "T": 2.0**20}
    return float(text[:-1]) * units[text[-1]] if text[-1] in units else float(text)


def main() -> int:
    """Run the demonstration; returns 0 if it passed or was skipped."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("targets", nargs="*", help="snakemake targets; default: the whole study")
    parser.add_argument("--minutes", type=float, default=40.0, help="time limit in minutes")
    arguments = parser.parse_args()
    if reason := why_not():
        print(f"slurm-demo skipped: {reason}")
        return 0

    def interrupted(number, frame):
        raise KeyboardInterrupt

    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupted)
    folder = Path(tempfile.mkdtemp(prefix="abradem-slurm-"))
    cluster = Cluster(folder)
    passed = interrupt = False
    try:
        cluster.start()
        say(f"{cluster.command('sinfo', '--version').strip()}: nodes {cluster.node_states()}")
        passed = demonstrate(cluster, arguments.targets, arguments.minutes)
    except DemoError as error:
        say(f"Slurm demonstration: FAILED: {error}")
    except KeyboardInterrupt:
        interrupt = True
        say("Slurm demonstration: interrupted")
    finally:
        # A second interruption must not leave processes running.
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        cluster.stop()
        if passed or interrupt:
            shutil.rmtree(folder, ignore_errors=True)
        else:
            say(f"logs of the daemons are kept in {folder}")
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
