"""Cracks in pictures of particles: what of the material around a particle is on its side of them, and faces that move with it.

All is told in the reference configuration, where cracks are lines; what a particle has, its share of its cell or a part of a face, is
then moved by its displacement. So colours end at the faces, and cracks open.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Array
from .frames import Crack

Shift = Callable[[Array, Array], Array]     # of points, by the numbers of their particles

RAYS = 96        # from a particle, by which its outline is found; a multiple of 8, so that corners of squares are among them
PAST = 1e-6      # angle by which rays pass the ends of lines on either side [rad]
BESIDE = 0.01    # of the size of a square: how far beside a line a point stands that is to be on one side of it
NEAREST = 16     # particles among which the one is looked for that moves a point of a face
COVERED = 0.85   # of their size: how far from a particle there is material, which may be in parts of squares at cracks
REACH = 1.5      # sizes of their squares: how far from it particles move it
PARTS = 400      # of a straight part of a crack, at most


def segments_of(cracks: Sequence[Crack]) -> Array:
    """The straight parts of cracks, shape (n, 2, 2)."""
    return np.concatenate([np.empty((0, 2, 2)), *(np.stack([crack.points[:-1], crack.points[1:]], axis=1) for crack in cracks)])


def ends_of(cracks: Sequence[Crack]) -> Array:
    """The tips of cracks, each as its place and the direction in which it points, shape (n, 2, 2)."""
    ends = [(crack.points[place], crack.points[place] - crack.points[before]) for crack in cracks
            for place, before in ((0, 1), (-1, -2)) if crack.tips[place]]
    return np.array([(tip, along / np.linalg.norm(along)) for tip, along in ends]).reshape(-1, 2, 2)


def near(places: Array, width: Array, segments: Array) -> Array:
    """In the square of which particles, of this width, a segment may be."""
    found = np.zeros(len(places), dtype=bool)
    for start, end in segments:
        along = end - start
        part = np.clip((places - start) @ along / (along @ along), 0, 1)
        found |= np.linalg.norm(places - start - part[:, None] * along, axis=1) < width / np.sqrt(2)
    return found


def beside(places: Array, side: Array, width: Array, segments: Array) -> Array:
    """Places of particles, of which those on a line are moved a little to their side of it: 1 to the left, -1 to the right."""
    moved = places.copy()
    for start, end in segments:
        along = (end - start) / np.linalg.norm(end - start)
        left = np.array([-along[1], along[0]])
        height, way = (places - start) @ left, (places - start) @ along
        on_line = (np.abs(height) < BESIDE / 2 * width) & (way > 0) & (way < np.linalg.norm(end - start))
        moved[on_line] += (side * BESIDE * width)[on_line, None] * left
    return moved


def seen_from(places: Array, lower: Array, upper: Array, segments: Array, ends: Array, width: Array) -> Array:
    """Outlines of what is seen from places in rectangles around them (corners lower, upper) past segments, shape (n, RAYS or more, 2).

    From ahead of a tip both faces are seen. What is behind the tip and within a width of it is left out: it moves with the faces.
    """
    touched = np.array([np.all((lower < line.max(axis=0)) & (upper > line.min(axis=0)), axis=1) for line in segments])
    ray = rays(places, segments, touched)
    with np.errstate(divide="ignore", invalid="ignore"):
        to_edges = np.where(ray > 0, upper[:, None] - places[:, None], lower[:, None] - places[:, None]) / ray
        far = np.nanmin(np.where(np.abs(ray) > 1e-9, to_edges, np.inf), axis=2)

        def end_at(start: Array, end: Array, chosen: Array) -> None:
            distance, part = meeting(places[chosen, None], ray[chosen], start, end)
            meets = (distance > 0) & (part > -1e-9) & (part < 1 + 1e-9)
            far[chosen] = np.where(meets, np.minimum(far[chosen], distance), far[chosen])

        for (start, end), chosen in zip(segments, touched):
            end_at(start, end, chosen)
        for tip, along in ends:
            ahead = ((places - tip) @ along > 0) & np.all((lower < tip) & (upper > tip), axis=1)
            aside = width[ahead, None, None] * [-along[1], along[0]]
            end_at(tip - aside, tip + aside, ahead)
    return places[:, None] + far[..., None] * ray


def rays(places: Array, segments: Array, touched: Array) -> Array:
    """Unit vectors all around places, and past the ends of the segments that touch what is around each; shape (n, RAYS or more, 2)."""
    most = touched.sum(axis=0).max()
    nearby = segments[np.argsort(~touched, axis=0, kind="stable")[:most].T]
    to_ends = (nearby - places[:, None, None]).reshape(len(places), -1, 2)
    past = (np.arctan2(to_ends[..., 1], to_ends[..., 0])[..., None] + [-PAST, PAST]).reshape(len(places), -1)
    all_around = np.broadcast_to(2 * np.pi * np.arange(RAYS) / RAYS, (len(places), RAYS))
    angle = np.sort(np.mod(np.concatenate([all_around, past], axis=1), 2 * np.pi), axis=1)
    return np.stack([np.cos(angle), np.sin(angle)], axis=2)


def is_between(one: Array, other: Array, segments: Array) -> Array:
    """Whether a segment runs between points, each to each."""
    blocked = np.zeros(len(one), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        for start, end in segments:
            distance, part = meeting(one, other - one, start, end)
            blocked |= (distance > 0) & (distance < 1) & (part > -1e-9) & (part < 1 + 1e-9)
    return blocked


def meeting(place: Array, ray: Array, start: Array, end: Array) -> tuple[Array, Array]:
    """Where a ray from a place meets the line from start to end: the way in lengths of the ray, and the part of the line."""
    def cross(a: Array, b: Array) -> Array:
        return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    to_start, along = start - place, end - start
    across = cross(ray, along)
    return cross(to_start, along) / across, cross(to_start, ray) / across


def faces(crack: Crack, places: Array, width: Array, shift: Shift, segments: Array, boxes: tuple[Array, Array]) -> Array:
    """The two faces of a crack, left and right, each points that are moved by shift(points, numbers) of the nearest particles on their side;
    NaN where there is none near, and outside of the body. At a tip both meet, in the mean of both. Shape (2, n, 2)."""
    step = max(width.min() / 2, max(np.linalg.norm(np.diff(crack.points, axis=0), axis=1)) / PARTS) if len(places) else np.inf
    parts: tuple[list[Array], list[Array]] = ([], [])
    for start, end in zip(crack.points, crack.points[1:]):
        length = np.linalg.norm(end - start)
        left = np.array([start[1] - end[1], end[0] - start[0]]) / length
        line = start + np.linspace(0, 1, int(np.ceil(length / step)) + 1)[:, None] * (end - start)
        line[~(are_covered(line, places, width) & are_within(line, *boxes))] = np.nan
        for face, normal in zip(parts, (left, -left)):
            face.append(line + moved_by(line, normal, places, width, shift, segments))
    moved = np.array([np.concatenate(face) for face in parts])
    for number, place in ((crack.tips[0], 0), (crack.tips[-1], -1)):
        known = moved[~np.isnan(moved[:, place, 0]), place]
        if number and len(known):
            moved[:, place] = known.mean(axis=0)
    return moved


def are_covered(points: Array, places: Array, width: Array) -> Array:
    """Whether points are in the square of some particle."""
    return np.array([np.any(np.abs(point - places).max(axis=1) < COVERED * width) for point in points], dtype=bool).reshape(-1)


def are_within(points: Array, lower: Array, upper: Array) -> Array:
    """Whether points are in some box of those with these corners, (n, 2) each."""
    return np.any(np.all((points[:, None] > lower - 1e-9) & (points[:, None] < upper + 1e-9), axis=2), axis=1)


def moved_by(line: Array, normal: Array, places: Array, width: Array, shift: Shift, segments: Array) -> Array:
    """How the nearest particle that is seen from each point of a line, on the side of the normal, moves it."""
    found = np.full(line.shape, np.nan)
    if not len(places):
        return found
    distance = np.linalg.norm(line[:, None] - places, axis=2)
    nearest = np.argsort(distance, axis=1, kind="stable")[:, :NEAREST]
    for k in nearest.T:
        start = line + BESIDE / 2 * width[k, None] * normal
        is_near = distance[np.arange(len(line)), k] < REACH * width[k]
        chosen = np.isnan(found[:, 0]) & is_near & ((places[k] - line) @ normal > 0) & ~is_between(start, places[k], segments)
        found[chosen] = shift(line[chosen], k[chosen])
    return found
