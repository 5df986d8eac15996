"""Environment variables that numba reads when it is imported, removed before it is.

The kernels run as compiled code alone, and without the threads of numba.
"""

from __future__ import annotations

import os
import sys

READ_AT_IMPORT = ("NUMBA_DISABLE_JIT", "NUMBA_NUM_THREADS")

if "numba" not in sys.modules:
    for _name in READ_AT_IMPORT:
        os.environ.pop(_name, None)
