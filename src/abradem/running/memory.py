"""Jobs that the operating system ended for want of memory, which they cannot say themselves."""

from __future__ import annotations

import re
from pathlib import Path

COUNTERS = (Path("/proc/vmstat"), Path("/sys/fs/cgroup/memory.events"))
"""Files with the number of processes ended so far: of the machine, and of this control group."""


def memory_kills() -> int:
    """Number of processes ended for want of memory since the machine started; 0 if unknown."""
    for path in COUNTERS:
        try:
            text = path.read_text(encoding="ascii")
        except (OSError, ValueError):
            continue
        if found := re.search(r"^oom_kill (\d+)$", text, re.MULTILINE):
            return int(found[1])
    return 0


def killed_for_memory(before: int) -> str | None:
    """The line on processes that were ended since `memory_kills` was ``before``, or None."""
    count = memory_kills() - before
    if count <= 0:
        return None
    processes = "1 process was" if count == 1 else f"{count} processes were"
    return (
        f"there was too little memory: during this run {processes} ended by the operating system; "
        "run fewer jobs at once (--cores) or raise the limit of memory"
    )
