"""Snakemake in a process that has imported all it needs; each call is a fork of it.

A dry run takes as long to import Snakemake and scipy as to look at the jobs. Modules of this
package are imported by the fork, so an edit takes effect.
"""

import contextlib
import json
import subprocess
import sys

# Given as text, so that the path of modules is that of ``python -m snakemake``.
SERVER = """
import json, os, sys
import pandas, pydantic, scipy.optimize, scipy.spatial, scipy.stats, yaml
import snakemake.cli, snakemake.persistence.file, snakemake.scheduling.job_scheduler
import snakemake.workflow
snakemake.cli.get_argument_parser()
for line in sys.stdin:
    arguments, said = json.loads(line)
    child = os.fork()
    if child == 0:
        for stream in (1, 2):
            os.dup2(os.open(said, os.O_WRONLY | os.O_CREAT | os.O_APPEND), stream)
        sys.argv = ["snakemake", *arguments]
        status = 70
        try:
            snakemake.cli.main()
        except SystemExit as end:
            status = end.code or 0
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@contextlib.contextmanager
def loaded_snakemake(folder, environment, said):
    """Give a function that runs Snakemake in ``folder`` and returns status and what it printed.

    ``said`` is the path of a file for that, which is overwritten.
    """
    with subprocess.Popen(
        [sys.executable, "-c", SERVER],
        cwd=folder, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as server:  # fmt: skip

        def run(*arguments):
            said.unlink(missing_ok=True)
            server.stdin.write(json.dumps([arguments, str(said)]) + "\n")
            server.stdin.flush()
            status = server.stdout.readline()
            assert status, "the process that had loaded Snakemake has ended"
            return int(status), said.read_text(encoding="utf-8")

        yield run
        server.stdin.close()
