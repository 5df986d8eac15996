"""What the noise of the wear, and the errors of its prediction, depend on: angle, speed and size.

On a flat plate a bed of particles lies, slow particles and few large ones scatter more. The
standardised terms ::

    exp(-tan |phi| / 0.15), ln Fr, ln R/H

are those of the noise of the Gaussian process (`abradem.learning.physical.gaussian_process`) and of
the error scale of its intervals (`abradem.learning.physical.error_scale`).
"""

from __future__ import annotations

import numpy as np

from abradem.surrogate.groups import GROUP_NAMES

FLATNESS = 0.15
"""Tangent of the angle, 8.5 deg, by which the effect of a flat plate falls by e."""

STEEPEST = np.radians(89.0)
"""Angle from which on the tangent grows without bound; the flatness is 0 there."""

TERMS = ("flatness", "log_froude", "log_size")
"""Names of the columns of `terms`."""


def terms(groups: np.ndarray) -> np.ndarray:
    """The terms, shape (n, 3), of rows with groups (n, 10)."""
    angle, speed, size = (
        groups[:, GROUP_NAMES.index(name)] for name in ("plate_angle", "log_froude", "log_size")
    )
    flatness = np.exp(-np.tan(np.minimum(np.abs(angle), STEEPEST)) / FLATNESS)
    return np.column_stack([flatness, speed, size])
