"""Ray casting of spheres above a plate, with exact outlines, shading and shadows.

Plotting libraries draw a sphere as polygons sorted by depth, which fails where particles touch
each other or the plate. Here every pixel shows the nearest surface on its ray; the intersection
with a sphere is the root of a quadratic equation, that with a parallelogram of a linear one.
Lengths are in metres and y points up. The plate is that of `abradem.dem.plate`: its centre is the
origin, and for positive angles it rises along +x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from abradem.dem.surface import Feed

LIGHT = np.array([0.35, -1.0, -0.45]) / np.linalg.norm([0.35, -1.0, -0.45])
"""Direction of the light."""

PARTICLE = np.array([0.53, 0.58, 0.64])
STEEL = np.array([0.72, 0.73, 0.75])
PATCH = np.array([0.0, 0.447, 0.698])

SLAB = 0.03
"""Thickness of the drawn plate divided by its length; the simulated plate has no thickness."""

_SHADOW_CELLS = 480
_AMBIENT, _DIFFUSE, _GLOSS = 0.42, 0.62, 0.28


@dataclass(frozen=True)
class Camera:
    """A perspective camera.

    Parameters
    ----------
    eye, target : ndarray, shape (3,)
        Position of the camera, and the point that it looks at, m.
    view : float
        Height of the field of view at the distance of the target, m.
    width, height : int
        Size of the picture, pixels.
    """

    eye: np.ndarray
    target: np.ndarray
    view: float
    width: int
    height: int

    @property
    def axes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Unit vectors to the right, up and forward, each of shape (3,)."""
        forward = (self.target - self.eye) / np.linalg.norm(self.target - self.eye)
        right = np.cross(forward, (0.0, 1.0, 0.0))
        right /= np.linalg.norm(right)
        return right, np.cross(right, forward), forward

    @property
    def focal(self) -> float:
        """Focal length in pixels."""
        return self.height * float(np.linalg.norm(self.target - self.eye)) / self.view

    def project(self, points) -> np.ndarray:
        """Pixel coordinates of points (n, 3), shape (n, 2): right and down from the upper left."""
        right, up, forward = self.axes
        away = np.atleast_2d(np.asarray(points, dtype=float)) - self.eye
        depth = away @ forward
        x = 0.5 * self.width + self.focal * (away @ right) / depth
        y = 0.5 * self.height - self.focal * (away @ up) / depth
        return np.column_stack([x, y])

    def rays(self, rows: slice, columns: slice) -> np.ndarray:
        """Directions through the centres of pixels, shape (rows, columns, 3).

        Their component along the line of sight is 1.
        """
        right, up, forward = self.axes
        x = (np.arange(columns.start, columns.stop) + 0.5 - 0.5 * self.width) / self.focal
        y = (0.5 * self.height - np.arange(rows.start, rows.stop) - 0.5) / self.focal
        return forward + x[None, :, None] * right + y[:, None, None] * up


@dataclass(frozen=True)
class DrawnPlate:
    """The plate as drawn.

    Parameters
    ----------
    length, width : float
        Along the slope and along z, m.
    angle : float
        Degrees.
    colours : ndarray, shape (nx, nz, 3)
        Colour of every facet, 0 to 1.
    """

    length: float
    width: float
    angle: float
    colours: np.ndarray

    @property
    def along(self) -> np.ndarray:
        """Unit vector up the slope (for positive angles)."""
        return tilted(self.angle)

    @property
    def normal(self) -> np.ndarray:
        """Unit normal of the upper face."""
        return np.array([-self.along[1], self.along[0], 0.0])

    def point(self, along: float, across: float, above: float = 0.0) -> np.ndarray:
        """Point on or above the plate, shape (3,), m.

        Parameters
        ----------
        along, across : float
            From -1 to 1 over the length and over the width.
        above : float
            Height above the upper face, m.
        """
        return (
            0.5 * along * self.length * self.along
            + above * self.normal
            + np.array([0.0, 0.0, 0.5 * across * self.width])
        )


def tilted(angle: float) -> np.ndarray:
    """Unit vector along a slope of ``angle`` degrees about +z."""
    return np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0.0])


@dataclass(frozen=True)
class Patch:
    """The factory patch: length, width and height of its centre (m), and angle (degrees)."""

    length: float
    width: float
    height: float
    angle: float

    def corners(self) -> np.ndarray:
        """The corners in order, shape (4, 3), m."""
        along = 0.5 * self.length * tilted(self.angle)
        across = np.array([0.0, 0.0, 0.5 * self.width])
        centre = np.array([0.0, self.height, 0.0])
        return centre + np.array([-along - across, along - across, along + across, -along + across])


def patch_corners(feed: Feed) -> np.ndarray:
    """Corners of the factory patch in order, shape (4, 3), m."""
    along, across = 0.5 * np.array(feed.along), 0.5 * np.array(feed.across)
    return np.array(feed.centre) + np.array(
        [-along - across, along - across, along + across, across - along]
    )


def picture(
    camera: Camera,
    plate: DrawnPlate,
    centres: np.ndarray,
    radius: float,
    patch: Patch | None = None,
    tints: np.ndarray | None = None,
    finer: int = 2,
) -> np.ndarray:
    """Draw spheres above a plate.

    Parameters
    ----------
    camera : Camera
    plate : DrawnPlate
    centres : ndarray, shape (n, 3)
        Centres of the spheres, m.
    radius : float
        m.
    patch : Patch, optional
        Drawn semi-transparent.
    tints : ndarray, shape (n,), optional
        Factor for the brightness of each sphere.
    finer : int
        Rays along each edge of a pixel; the pixel shows their mean.

    Returns
    -------
    ndarray, shape (height, width, 3)
        Colours from 0 to 1, on a white background.
    """
    fine = Camera(
        camera.eye, camera.target, camera.view, camera.width * finer, camera.height * finer
    )
    image = np.ones((fine.height, fine.width, 3))
    depth = np.full((fine.height, fine.width), np.inf)
    centres = np.asarray(centres, dtype=float).reshape(-1, 3)
    _draw_plate(image, depth, fine, plate, _shadows(plate, centres, radius))
    tints = np.ones(len(centres)) if tints is None else tints
    for centre, tint in zip(centres, tints, strict=True):
        draw_sphere(image, depth, fine, centre, radius, tint * PARTICLE)
    if patch is not None:
        _draw_patch(image, depth, fine, patch)
    image = image.reshape(camera.height, finer, camera.width, finer, 3).mean(axis=(1, 3))
    return np.clip(image, 0.0, 1.0)


def lit(normals: np.ndarray, shadow=0.0) -> np.ndarray:
    """Brightness of surfaces from ambient and directed light."""
    sky = _AMBIENT * (0.8 + 0.2 * normals[..., 1])
    return sky + _DIFFUSE * np.clip(-(normals @ LIGHT), 0.0, 1.0) * (1.0 - shadow)


def window_of(corners: np.ndarray, camera: Camera) -> tuple[slice, slice] | None:
    """Rows and columns of the picture around some pixels; None if all are outside of it."""
    low = np.floor(corners.min(axis=0)).astype(int) - 1
    high = np.ceil(corners.max(axis=0)).astype(int) + 2
    columns = slice(max(low[0], 0), min(high[0], camera.width))
    rows = slice(max(low[1], 0), min(high[1], camera.height))
    if columns.start >= columns.stop or rows.start >= rows.stop:
        return None
    return rows, columns


def draw_sphere(image, depth, camera, centre, radius, colour) -> None:
    """Draw a sphere into a picture (height, width, 3) with the depth of each pixel, m."""
    forward = camera.axes[2]
    away = float((centre - camera.eye) @ forward)
    if away <= radius:
        return
    # In perspective the outline is slightly larger than the projected radius.
    half = 1.15 * camera.focal * radius / (away - radius)
    middle = camera.project(centre)[0]
    window = window_of(np.array([middle - half, middle + half]), camera)
    if window is None:
        return
    rays = camera.rays(*window)
    start = camera.eye - centre
    a = (rays**2).sum(axis=2)
    b = rays @ start
    root = b**2 - a * (start @ start - radius**2)
    met = root > 0.0
    t = np.where(met, (-b - np.sqrt(np.where(met, root, 0.0))) / a, np.inf)
    seen = met & (t < depth[window])
    if not seen.any():
        return
    normals = (start + t[seen][:, None] * rays[seen]) / radius
    sight = -rays[seen] / np.sqrt(a[seen])[:, None]
    half_way = sight - LIGHT
    half_way /= np.linalg.norm(half_way, axis=1)[:, None]
    gloss = _GLOSS * np.clip((normals * half_way).sum(axis=1), 0.0, 1.0) ** 40
    image[window][seen] = lit(normals)[:, None] * colour + gloss[:, None]
    depth[window][seen] = t[seen]


def _meet(camera, corner, edge_u, edge_v):
    """Intersection of rays and parallelogram: window, depth, shares along the edges, hits."""
    corners = np.array([corner, corner + edge_u, corner + edge_v, corner + edge_u + edge_v])
    window = window_of(camera.project(corners), camera)
    if window is None:
        return None
    rays = camera.rays(*window)
    normal = np.cross(edge_u, edge_v)
    slope = rays @ normal
    slope = np.where(np.abs(slope) < 1e-12, np.nan, slope)
    t = ((corner - camera.eye) @ normal) / slope
    place = camera.eye + t[..., None] * rays - corner
    u = place @ (edge_u / (edge_u @ edge_u))
    v = place @ (edge_v / (edge_v @ edge_v))
    met = (t > 0.0) & (u >= 0.0) & (u <= 1.0) & (v >= 0.0) & (v <= 1.0)
    return window, t, u, v, met


def _draw_plate(image, depth, camera, plate, shadows) -> None:
    up, down = plate.normal, -SLAB * plate.length * plate.normal
    along = plate.length * plate.along
    across = np.array([0.0, 0.0, plate.width])
    corner = plate.point(-1.0, -1.0)
    sides = (
        (corner, along, down), (corner + across, along, down),
        (corner, across, down), (corner + along, across, down),
        (corner + down, along, across),
    )  # fmt: skip
    outward = (-across, across, -along, along, down)
    for (start, u, v), normal in zip(sides, outward, strict=True):
        found = _meet(camera, start, u, v)
        if found is None:
            continue
        window, t, _, _, met = found
        seen = met & (t < depth[window])
        image[window][seen] = lit(normal / np.linalg.norm(normal)) * STEEL
        depth[window][seen] = t[seen]
    found = _meet(camera, corner, along, across)
    if found is None:
        return
    window, t, u, v, met = found
    seen = met & (t < depth[window])
    i = _cells(u[seen], plate.colours.shape[0])
    j = _cells(v[seen], plate.colours.shape[1])
    shadow = shadows[_cells(u[seen], _SHADOW_CELLS), _cells(v[seen], _SHADOW_CELLS)]
    # The colours of the wear map are data, so the light on the slope does not change them.
    brightness = 1.0 - 0.45 * shadow
    if (camera.eye @ up) < 0.0:
        image[window][seen] = lit(-up) * STEEL
    else:
        image[window][seen] = brightness[:, None] * plate.colours[i, j]
    depth[window][seen] = t[seen]


def _cells(share: np.ndarray, count: int) -> np.ndarray:
    return np.clip((share * count).astype(int), 0, count - 1)


def _shadows(plate, centres, radius) -> np.ndarray:
    """Share of the directed light that the spheres block, on a grid over the upper face."""
    frame = np.array([plate.along, plate.normal, [0.0, 0.0, 1.0]])
    light = frame @ LIGHT
    kept = np.zeros((_SHADOW_CELLS, _SHADOW_CELLS))
    if light[1] >= -0.05:
        return kept
    cell = np.array([plate.length, plate.width]) / _SHADOW_CELLS
    for place in centres @ frame.T:
        height = place[1]
        if height <= 0.0:
            continue
        # Shadows of higher particles have softer edges.
        soft = 0.15 * radius + 0.12 * height
        foot = place[[0, 2]] - light[[0, 2]] * height / light[1]
        reach = (radius + soft) / -light[1]
        low = np.floor((foot - reach) / cell + 0.5 * _SHADOW_CELLS).astype(int)
        high = np.ceil((foot + reach) / cell + 0.5 * _SHADOW_CELLS).astype(int)
        low, high = np.clip(low, 0, _SHADOW_CELLS), np.clip(high, 0, _SHADOW_CELLS)
        if (low >= high).any():
            continue
        s = (np.arange(low[0], high[0]) + 0.5 - 0.5 * _SHADOW_CELLS) * cell[0] - place[0]
        w = (np.arange(low[1], high[1]) + 0.5 - 0.5 * _SHADOW_CELLS) * cell[1] - place[2]
        s, w = s[:, None], w[None, :]
        towards = s * light[0] - height * light[1] + w * light[2]
        apart = np.sqrt(np.maximum(s**2 + height**2 + w**2 - towards**2, 0.0))
        share = np.clip((radius + 0.5 * soft - apart) / soft, 0.0, 1.0)
        share = share**2 * (3.0 - 2.0 * share) * min(1.0, (2.0 * radius / (radius + soft)) ** 2)
        part = kept[low[0] : high[0], low[1] : high[1]]
        np.maximum(part, share, out=part)
    return kept


def _draw_patch(image, depth, camera, patch) -> None:
    corners = patch.corners()
    found = _meet(camera, corners[0], corners[1] - corners[0], corners[3] - corners[0])
    if found is None:
        return
    window, t, u, v, met = found
    seen = met & (t < depth[window])
    border = np.minimum(np.minimum(u, 1.0 - u), np.minimum(v, 1.0 - v))[seen] < 0.025
    cover = np.where(border, 0.95, 0.30)[:, None]
    image[window][seen] = (1.0 - cover) * image[window][seen] + cover * PATCH
