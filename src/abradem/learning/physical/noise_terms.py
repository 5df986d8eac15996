"""What the noise of the wear, and the errors of its prediction, depend on: angle, speed and size.

On a flat plate a bed of particles lies, slow particles and few large ones scatter more. So the
terms of the noise of the Gaussian process (`abradem.learning.physical.gaussian_process`) are ::

    exp(-tan |phi| / 0.15), ln Fr, ln R/H

Errors of the prediction may also be largest on gentle slopes, where a bed slides or stays, and
smaller on flat and on steep plates. The terms of the error scale of its intervals
(`abradem.learning.physical.error_scale`) are ::

    exp(-u), u exp(1 - u), ln Fr, ln R/H        u = tan |phi| / 0.3

The second is largest at u = 1, a slope of 17 deg.
"""

from __future__ import annotations

import numpy as np

from abradem.surrogate.groups import GROUP_NAMES

FLATNESS = 0.15
"""Tangent of the angle, 8.5 deg, by which the effect of a flat plate on the noise falls by e."""

GENTLE = 0.3
"""Tangent of the slope, 16.7 deg, at which the second term of the error scale is largest."""

STEEPEST = np.radians(89.0)
"""Angle from which on the tangent grows without bound; the terms of the angle are 0 there."""

ERROR_TERMS = ("flat_plate", "gentle_slope", "log_froude", "log_size")
"""Names of the columns of `error_terms`."""


def noise_terms(groups: np.ndarray) -> np.ndarray:
    """Terms of the noise (flatness, ln Fr, ln R/H), shape (n, 3), of rows with groups (n, 10)."""
    tangent, speed, size = _tangent_speed_size(groups)
    return np.column_stack([np.exp(-tangent / FLATNESS), speed, size])


def error_terms(groups: np.ndarray) -> np.ndarray:
    """Terms of the error scale, shape (n, 4), of rows with groups (n, 10)."""
    tangent, speed, size = _tangent_speed_size(groups)
    u = tangent / GENTLE
    return np.column_stack([np.exp(-u), u * np.exp(1.0 - u), speed, size])


def _tangent_speed_size(groups: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    angle, speed, size = (
        groups[:, GROUP_NAMES.index(name)] for name in ("plate_angle", "log_froude", "log_size")
    )
    return np.tan(np.minimum(np.abs(angle), STEEPEST)), speed, size
