"""Whether worker processes end."""

import os
import signal
import time


def has_ended(process: int, seconds: float = 60.0) -> bool:
    """Whether a process ends within some seconds; if not, it is killed."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    os.kill(process, signal.SIGKILL)
    return False
