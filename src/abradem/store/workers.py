"""Worker processes that end with the process that they work for."""

from __future__ import annotations

import os
import threading
from multiprocessing import parent_process


def end_with_parent() -> None:
    """End this worker process when its parent is killed: it would wait for work for ever.

    For the ``initializer`` of a pool. In a process without a parent nothing happens.
    """
    parent = parent_process()
    if parent is None:
        return

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
