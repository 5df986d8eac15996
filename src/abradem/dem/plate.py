"""Geometry of the plate: a rectangle without thickness, with contacts at edges and corners.

The centre of the plate is the origin; ``a = (cos phi, sin phi, 0)`` is along its length,
``h = (-sin phi, cos phi, 0)`` is its normal and z is along its width.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abradem.dem.cache import kernel
from abradem.dem.vectors import dot, fma


class Plate(NamedTuple):
    """Extent, tilt and facets of the plate, SI."""

    cos: float
    sin: float
    half_length: float
    half_width: float
    facets_x: int
    facets_z: int
    # Facets per metre.
    scale_x: float
    scale_z: float


def make_plate(length: float, width: float, angle_deg: float, facets: tuple[int, int]) -> Plate:
    """Return the plate tilted by ``angle_deg`` about +z."""
    angle = math.radians(angle_deg)
    return Plate(
        cos=math.cos(angle),
        sin=math.sin(angle),
        half_length=0.5 * length,
        half_width=0.5 * width,
        facets_x=facets[0],
        facets_z=facets[1],
        scale_x=facets[0] / length,
        scale_z=facets[1] / width,
    )


@kernel(inline=True)
def height_over(plate, x, y):
    """Signed distance from the plane of the plate, m."""
    return fma(plate.cos, y, -(plate.sin * x))


@kernel(inline=True)
def plate_distance(plate, x, y, z):
    """Return distance to the plate, unit normal towards the point, nearest (along, z), on_face.

    ``on_face`` is False if the nearest point of the plate is on an edge or corner.
    """
    along = fma(plate.cos, x, plate.sin * y)
    height = height_over(plate, x, y)
    near_along = min(max(along, -plate.half_length), plate.half_length)
    near_z = min(max(z, -plate.half_width), plate.half_width)
    side = along - near_along
    dz = z - near_z
    if side == 0.0 and dz == 0.0:
        if height >= 0.0:
            return height, (-plate.sin, plate.cos, 0.0), near_along, near_z, True
        return -height, (plate.sin, -plate.cos, 0.0), near_along, near_z, True
    distance = math.sqrt(dot((side, height, dz), (side, height, dz)))
    n = (
        fma(side, plate.cos, -(height * plate.sin)) / distance,
        fma(side, plate.sin, height * plate.cos) / distance,
        dz / distance,
    )
    return distance, n, near_along, near_z, False


@kernel(inline=True)
def facet_of(plate, along, z):
    """Return the facet (ix, iz) of a point on the plate."""
    ix = int((along + plate.half_length) * plate.scale_x)
    iz = int((z + plate.half_width) * plate.scale_z)
    return min(max(ix, 0), plate.facets_x - 1), min(max(iz, 0), plate.facets_z - 1)
