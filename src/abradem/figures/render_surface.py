"""Ray casting of spheres in and on a triangulated surface, whose walls are seen through.

A chute has walls between the camera and what happens in it. So every pixel gets all triangles on
its ray, from the farthest to the nearest, each with the cover of its colour; spheres are opaque.
What does not change from picture to picture, the triangles on each ray, is found once, in `Layers`.
Lengths are in metres and y points up; see `abradem.figures.render`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abradem.figures.render import LIGHT, PARTICLE, PATCH, Camera, draw_sphere, lit, window_of

RIM = np.array([0.27, 0.29, 0.32])
RIM_COVER, PATCH_COVER = 0.85, 0.30

_SHADOW = 0.45
"""Share of the brightness that a shadow takes."""

_SHADOW_CELLS_PER_RADIUS = 10
_MOST_SHADOW_CELLS = 3000


class Layers(NamedTuple):
    """All fragments of a drawing: what a ray through a pixel meets, from far to near.

    Attributes
    ----------
    camera : Camera
        Of the fine picture, with several rays in a pixel.
    finer : int
        Rays along each edge of a pixel.
    pixel, depth : ndarray, shape (n,)
        Pixel of each fragment, and its distance along the line of sight, m.
    face : ndarray of int, shape (n,)
        Triangle; `_LINE` and `_PATCH` for rims, and for the factory.
    ranks : tuple of ndarray of int
        Fragments that are the farthest of their pixel, the second farthest, ...
    brightness : ndarray, shape (t,)
        Of the triangles in the light.
    """

    camera: Camera
    finer: int
    pixel: np.ndarray
    depth: np.ndarray
    face: np.ndarray
    ranks: tuple[np.ndarray, ...]
    brightness: np.ndarray


_LINE, _PATCH, _PATCH_RIM = -1, -2, -3


def layers_of(
    camera: Camera, corners: np.ndarray, rims: np.ndarray, patch: np.ndarray, finer: int = 2
) -> Layers:
    """Return the fragments of a surface and of the factory patch.

    Parameters
    ----------
    camera : Camera
    corners : ndarray, shape (t, 3, 3)
        Corners of the triangles, m.
    rims : ndarray, shape (r, 2, 3)
        Ends of the lines that are drawn, m.
    patch : ndarray, shape (4, 3)
        Corners of the factory patch in order, m.
    finer : int
        Rays along each edge of a pixel; the pixel shows their mean.
    """
    fine = Camera(
        camera.eye, camera.target, camera.view, camera.width * finer, camera.height * finer
    )
    found = [_triangle(fine, triangle, number) for number, triangle in enumerate(corners)]
    for half in (patch[[0, 1, 2]], patch[[0, 2, 3]]):
        found.append(_triangle(fine, half, _PATCH))
    border = np.stack([patch, np.roll(patch, -1, axis=0)], axis=1)
    found += [_lines(fine, rims, _LINE, finer), _lines(fine, border, _PATCH_RIM, finer + 1)]
    pixel, depth, face = (
        np.concatenate([one[part] for one in found if one is not None]) for part in range(3)
    )
    order = np.lexsort((face, -depth, pixel))
    pixel, depth, face = pixel[order], depth[order], face[order]
    first = np.flatnonzero(np.r_[True, pixel[1:] != pixel[:-1]]) if pixel.size else pixel
    rank = np.arange(pixel.size) - np.repeat(first, np.diff(np.r_[first, pixel.size]))
    by_rank = np.argsort(rank, kind="stable")
    ends = np.cumsum(np.bincount(rank)) if rank.size else np.zeros(0, dtype=int)
    return Layers(
        fine,
        finer,
        pixel,
        depth,
        face,
        tuple(np.split(by_rank, ends[:-1])),
        _light_on(fine, corners),
    )


def in_front(layers: Layers, count: int) -> np.ndarray:
    """Return which of ``count`` triangles are the nearest ones in most of their pixels."""
    on_triangle = layers.face >= 0
    pixel, face = layers.pixel[on_triangle], layers.face[on_triangle]
    nearest = np.r_[pixel[1:] != pixel[:-1], True][: pixel.size]
    seen = np.bincount(face[nearest], minlength=count)
    return 2 * seen > np.bincount(face, minlength=count)


def picture_of_surface(
    layers: Layers,
    colours: np.ndarray,
    cover: np.ndarray,
    shaded: np.ndarray,
    centres: np.ndarray,
    radius: float,
    tints: np.ndarray | None = None,
) -> np.ndarray:
    """Draw spheres and a surface.

    Parameters
    ----------
    layers : Layers
    colours : ndarray, shape (t, 3)
        Colours of the triangles, 0 to 1.
    cover : ndarray, shape (t,)
        How much of what is behind a triangle hides, 0 to 1.
    shaded : ndarray of bool, shape (t,)
        Whether the light changes the colour of a triangle; a colour that is data stays.
    centres : ndarray, shape (n, 3)
        m.
    radius : float
        m.
    tints : ndarray, shape (n,), optional
        Factor for the brightness of each sphere.

    Returns
    -------
    ndarray, shape (height, width, 3)
        Colours from 0 to 1, on a white background.
    """
    fine, finer = layers.camera, layers.finer
    image = np.ones((fine.height, fine.width, 3))
    depth = np.full((fine.height, fine.width), np.inf)
    centres = np.asarray(centres, dtype=float).reshape(-1, 3)
    tints = np.ones(len(centres)) if tints is None else tints
    for centre, tint in zip(centres, tints, strict=True):
        draw_sphere(image, depth, fine, centre, radius, tint * PARTICLE)
    # The last three entries are for the negative numbers of lines and of the patch.
    bright = np.where(shaded, layers.brightness, 1.0)
    paint = np.concatenate([bright[:, None] * colours, [PATCH, PATCH, RIM]])
    covers = np.concatenate([cover, [RIM_COVER, PATCH_COVER, RIM_COVER]])
    shadow = _shadows(layers, centres, radius)
    flat, near = image.reshape(-1, 3), depth.reshape(-1)
    for chosen in layers.ranks:
        chosen = chosen[layers.depth[chosen] < near[layers.pixel[chosen]]]
        pixel, face = layers.pixel[chosen], layers.face[chosen]
        colour = paint[face] * (1.0 - _SHADOW * shadow[chosen])[:, None]
        share = covers[face][:, None]
        flat[pixel] = (1.0 - share) * flat[pixel] + share * colour
    image = image.reshape(
        fine.height // finer, finer, fine.width // finer, finer, 3
    ).mean(axis=(1, 3))  # fmt: skip
    return np.clip(image, 0.0, 1.0)


def _triangle(camera: Camera, corners: np.ndarray, number: int):
    """Pixels, depths and number of the fragments of a triangle, or None."""
    window = window_of(camera.project(corners), camera)
    if window is None:
        return None
    rays = camera.rays(*window)
    edge_u, edge_v = corners[1] - corners[0], corners[2] - corners[0]
    normal = np.cross(edge_u, edge_v)
    slope = rays @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = ((corners[0] - camera.eye) @ normal) / slope
    # Shares u and v of the edges at the meeting point, from the areas of the partial triangles.
    place = camera.eye - corners[0] + depth[..., None] * rays
    area2 = normal @ normal
    u = place @ (np.cross(edge_v, normal) / area2)
    v = place @ (np.cross(normal, edge_u) / area2)
    met = (depth > 0.0) & np.isfinite(depth) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    row, column = np.nonzero(met)
    pixel = (row + window[0].start) * camera.width + column + window[1].start
    return pixel, depth[met], np.full(pixel.size, number)


def _lines(camera: Camera, ends: np.ndarray, number: int, width: int):
    """Pixels, depths and number of the fragments of lines, ``width`` pixels wide."""
    if not len(ends):
        return None
    forward = camera.axes[2]
    places = []
    for begin, end in ends:
        length = np.linalg.norm(np.diff(camera.project([begin, end]), axis=0))
        share = np.linspace(0.0, 1.0, max(2, math.ceil(length)))[:, None]
        places.append((1.0 - share) * begin + share * end)
    points = np.concatenate(places)
    away = np.arange(width) - width // 2
    spread = np.stack(np.meshgrid(away, away), axis=-1).reshape(1, -1, 2)
    at = (np.floor(camera.project(points)).astype(int)[:, None, :] + spread).reshape(-1, 2)
    # Slightly nearer than the triangles beside the line.
    depth = np.repeat(0.999 * ((points - camera.eye) @ forward), spread.shape[1])
    inside = ((at >= 0) & (at < [camera.width, camera.height])).all(axis=1)
    pixel, depth = at[inside, 1] * camera.width + at[inside, 0], depth[inside]
    order = np.lexsort((depth, pixel))
    pixel, first = np.unique(pixel[order], return_index=True)
    return pixel, depth[order][first], np.full(pixel.size, number)


def _light_on(camera: Camera, corners: np.ndarray) -> np.ndarray:
    """Brightness of the triangles on the side that the camera sees, shape (t,)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    towards = np.einsum("ij,ij->i", normal, camera.eye - corners[:, 0])
    return lit(np.where(towards[:, None] < 0.0, -normal, normal))


def _shadows(layers: Layers, centres: np.ndarray, radius: float) -> np.ndarray:
    """Which fragments are in the shadow of a sphere, 0 or 1, shape (n,)."""
    dark = np.zeros(layers.pixel.size)
    if not len(centres):
        return dark
    across = np.cross(LIGHT, (0.0, 0.0, 1.0))
    across /= np.linalg.norm(across)
    frame = np.array([across, np.cross(LIGHT, across), LIGHT])
    camera = layers.camera
    row, column = np.divmod(layers.pixel, camera.width)
    right, up, forward = camera.axes
    x = (column + 0.5 - 0.5 * camera.width) / camera.focal
    y = (0.5 * camera.height - row - 0.5) / camera.focal
    # Positions of the fragments in the frame of the light, without an array of rays.
    seen = (
        frame @ camera.eye
        + layers.depth[:, None] * (frame @ forward)
        + (layers.depth * x)[:, None] * (frame @ right)
        + (layers.depth * y)[:, None] * (frame @ up)
    )
    balls = centres @ frame.T
    low, high = balls[:, :2].min(axis=0) - radius, balls[:, :2].max(axis=0) + radius
    cell = max(radius / _SHADOW_CELLS_PER_RADIUS, float((high - low).max()) / _MOST_SHADOW_CELLS)
    shape = np.ceil((high - low) / cell).astype(int) + 1
    reach = math.ceil(radius / cell)
    disc = np.stack(np.meshgrid(*2 * [np.arange(-reach, reach + 1)]), axis=-1).reshape(-1, 2)
    disc = disc[(disc**2).sum(axis=1) * cell**2 <= radius**2]
    at = np.floor((balls[:, :2] - low) / cell).astype(int)[:, None, :] + disc
    at = np.clip(at, 0, shape - 1)
    nearest = np.full(shape[0] * shape[1], np.inf)
    np.minimum.at(
        nearest, (at[..., 0] * shape[1] + at[..., 1]).ravel(), np.repeat(balls[:, 2], len(disc))
    )
    place = np.floor((seen[:, :2] - low) / cell).astype(int)
    inside = ((place >= 0) & (place < shape)).all(axis=1) & (layers.face >= 0)
    dark[inside] = nearest[place[inside, 0] * shape[1] + place[inside, 1]] < seen[inside, 2]
    return dark
