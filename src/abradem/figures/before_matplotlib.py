"""The backend of a notebook, which matplotlib reads when it is imported, removed before it is.

A notebook names its backend to all processes that it starts, also to those of a Python that lacks
it, where the import of matplotlib would fail. Figures are drawn without a backend; one that exists
stays that of pyplot.
"""

from __future__ import annotations

import importlib.util
import os
import sys

_backend = os.environ.get("MPLBACKEND", "")
if "matplotlib" not in sys.modules and _backend.startswith("module://"):
    if importlib.util.find_spec(_backend.removeprefix("module://").partition(".")[0]) is None:
        del os.environ["MPLBACKEND"]
