"""Triangles of a scene by Netgen, fine at tips and corners, parted along its cracks.

The geometry is Netgen's (OCC): bodies, cracks and the borders of boxes are glued, so that all of them are edges of elements. Nodes on cracks are doubled afterwards: one for each
group of triangles around a node that hang together without crossing a crack, so that kinks, mouths on edges and crossings need no thought of their own.
"""

import math
import tempfile
from collections import defaultdict
from dataclasses import dataclass

import netgen.meshing as netgen
import ngsolve as ng
import numpy as np
from netgen.occ import ArcOfCircle, Face, Glue, OCCGeometry, Segment, Vertex, Wire
from opinion_scene import FAR, NEAR, Outside, crossings, distance, left_of, unit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

COARSE, CORNER, GRADING = 1 / 7, 0.03, 0.35   # largest elements over the scene, those at corners and ends of loads, how fast they grow
SHARP = 5e-4                                  # those where stress has no bound: ends of supports, point loads, corners between bodies and that are no convex ones
AXIS = "axis"                                 # in place of an arc: edges around which material is
ON_ARC = 0.3                                  # elements on a circle over its radius
IN_RING = 0.25                                # elements around a tip over the distance
TIP = 2e-4                                    # elements at a tip over what fits around it


@dataclass
class Mesh:
    """What is solved on: the elements, and which parts of them are what, by names of regions."""

    elements: ng.Mesh
    parts: list            # of materials: (number of the body, numbers of holds, numbers of body loads)
    edges: list            # of boundaries: (numbers of holds, numbers of loads, crack or None, 'left' or 'right', arc, AXIS or None)
    rooms: list            # of tips: radius without anything but the crack; None where it cannot be measured in one material
    seams: list            # of tips: whether it runs between two bodies
    nodes: np.ndarray
    size: float            # of all bodies

    def materials(self, wanted):
        """The region of the parts of which `wanted` is true."""
        return self.elements.Materials("|".join(f"m{k}" for k, one in enumerate(self.parts) if wanted(one)) or "none")

    def boundaries(self, wanted):
        """The region of the edges of which `wanted` is true."""
        return self.elements.Boundaries("|".join(f"b{k}" for k, one in enumerate(self.edges) if wanted(one)) or "none")

    def node(self, place):
        """The number of the node at a place."""
        apart = np.linalg.norm(self.nodes - place, axis=1)
        if apart.min() > 1e-5:
            raise Outside("a point load or support outside of the material")
        return int(apart.argmin())


def within(place, lower, upper, margin=NEAR):
    """Whether a place is in a box."""
    return bool(np.all(place >= np.asarray(lower) - margin) and np.all(place <= np.asarray(upper) + margin))


def is_point(one):
    """Whether a box is a point."""
    return np.allclose(one.lower, one.upper, atol=NEAR)


def borders(one):
    """The sides of a box."""
    (x0, y0), (x1, y1) = one.lower, one.upper
    corners = [np.array(c, float) for c in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    return [(a, b) for a, b in zip(corners, corners[1:] + corners[:1]) if np.linalg.norm(b - a) > NEAR]


class Geometry:
    """The shapes of a scene, glued."""

    def __init__(self, scene):
        self.scene = scene
        self.boxes = [one for one in scene.holds + scene.loads if one.lower is not None]
        self.size = max(np.max([b.upper for b in scene.bodies], 0) - np.min([b.lower for b in scene.bodies], 0))
        self.faces = [self.face(body) for body in scene.bodies]
        for hole in scene.holes:
            cut = self.face(hole)
            self.faces = [face - cut for face in self.faces]
        material = Glue(self.faces)
        lines = [ends for crack in scene.cracks if crack.kind != "symmetry" for ends in crack.segments]
        for one in self.boxes:
            if getattr(one, "kind", "hold") in ("hold", "body") and not is_point(one):
                lines += borders(one)
        for body in scene.bodies:
            if body.at:
                along = FAR * left_of(body.direction)
                there = [piece[1:] for piece in scene.pieces() if piece[0] == "line"] + lines[:]      # glued to one along it edges would be twice there
                lines += [(at * body.direction - along, at * body.direction + along) for at in body.at
                          if not any(abs(a @ body.direction - at) + abs(b @ body.direction - at) < NEAR for a, b in there)]
        extra = [line for line in (Segment((*a, 0), (*b, 0)) * material for a, b in lines) if len(line.edges)]
        extra += [Vertex((*one.lower, 0)) for one in self.boxes if is_point(one) and scene.material_at(one.lower) is not None]
        self.shape = Glue([*self.faces, *extra]) if extra else material

    def marks(self, piece):
        """Places on a piece of an outline where boxes begin or end, and tips and mouths on it."""
        found = []
        for one in self.boxes:
            (x0, y0), (x1, y1) = one.lower, one.upper
            corners = [np.array(c, float) for c in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
            found += [c for c in corners if distance(c, piece) < NEAR]
            for a, b in borders(one):
                found += [a + t * (b - a) for t in crossings(a, b, piece) if 0 <= t <= 1]
        found += [p for crack in self.scene.cracks for p in crack.points if distance(p, piece) < 10 * NEAR]
        return found

    def face(self, body):
        """The face of a body, with vertices at all marks."""
        edges = []
        for piece in body.pieces:
            marks = self.marks(piece)
            if piece[0] == "line":
                a, b = np.asarray(piece[1], float), np.asarray(piece[2], float)
                parts = sorted({0.0, 1.0, *(round(float((m - a) @ (b - a) / ((b - a) @ (b - a))), 9) for m in marks)})
                parts = [t for t in parts if 0 <= t <= 1]
                parts = [t for t, before in zip(parts, [-1, *parts]) if (t - before) * np.linalg.norm(b - a) > 3 * NEAR]
                places = [a + t * (b - a) for t in parts[:-1]] + [b]
                edges += [Segment((*p, 0), (*q, 0)) for p, q in zip(places, places[1:])]
            else:
                middle, radius = piece[1:]
                angles = sorted(math.atan2(*(m - middle)[::-1]) % (2 * math.pi) for m in marks)
                angles = [t for t, before in zip(angles, [-1, *angles]) if t - before > 1e-6] or [0.0]
                for t, after in zip(angles, [*angles[1:], angles[0] + 2 * math.pi]):
                    pieces = max(1, math.ceil((after - t) / 2.0))
                    ends = np.linspace(t, after, 2 * pieces + 1)
                    at = [(middle[0] + radius * math.cos(s), middle[1] + radius * math.sin(s), 0) for s in ends]
                    edges += [ArcOfCircle(at[k], at[k + 1], at[k + 2]) for k in range(0, 2 * pieces, 2)]
        return Face(Wire(edges))

    def is_sharp(self, place):
        """Whether stress has no bound at a vertex."""
        ends = [(one.lower, one.upper) for one in self.boxes if getattr(one, "kind", "hold") in ("hold", "point")]
        if any(within(place, *ends_of) and np.min(np.abs(np.concatenate([place - ends_of[0], place - ends_of[1]]))) < NEAR for ends_of in ends):
            return min(distance(place, piece) for piece in self.scene.pieces()) < 1e-5 or any(is_point(one) for one in self.boxes)
        around = [place + 1e-4 * np.array([math.cos(t), math.sin(t)]) for t in np.linspace(0.01, 2 * math.pi + 0.01, 48, endpoint=False)]
        found = [self.scene.material_at(p) for p in around]
        inside = [body for body in found if body is not None]
        if len({id(body) for body in inside}) > 1 and len({body.material.key for body in inside}) > 1:
            return len(inside) != len(found) or any(np.linalg.norm(place - piece[1]) < 1e-5 for piece in self.scene.pieces())
        return 27 <= len(inside) < len(found)

    def elements(self, rooms):
        """Netgen's triangles."""
        tips, sizes = [tip.place for crack in self.scene.cracks for tip in crack.tips], []
        for vertex in self.shape.vertices:
            place = np.array([vertex.p.x, vertex.p.y])
            near = [room for tip, room in zip(tips, rooms) if np.linalg.norm(place - tip) < 1e-5]
            vertex.maxh = TIP * max(near[0], 0.05) if near else (SHARP if self.is_sharp(place) else CORNER) * self.size
        for tip, room in zip(tips, (max(room, 0.05) for room in rooms)):
            sizes += [(*(tip + part * room * np.array([math.cos(t), math.sin(t)])), IN_RING * part * room) for part in (0.3, 0.5, 0.7, 0.9) for t in np.linspace(-3, 3, 18)]
        for _, middle, radius in (piece for piece in self.scene.pieces() if piece[0] == "arc"):
            sizes += [(*(middle + radius * np.array([math.cos(t), math.sin(t)])), ON_ARC * radius) for t in np.linspace(0, 2 * math.pi, 24, endpoint=False)]
        with tempfile.NamedTemporaryFile("w", suffix=".msz") as file:
            file.write(f"{len(sizes)}\n" + "".join(f"{x} {y} 0 {h}\n" for x, y, h in sizes) + "0\n")
            file.flush()
            return OCCGeometry(self.shape, dim=2).GenerateMesh(maxh=COARSE * self.size, grading=GRADING, meshsizefilename=file.name)


def room_of(tip, scene):
    """How far around a tip there is nothing but its straight crack in one material, and whether that is the seam of two bodies."""
    seam, free = False, tip.straight
    mine = scene.body_at(tip)
    left = left_of(tip.direction)

    def alike(one, other):
        return one.material.key == other.material.key and np.allclose(one.eigenstrain, other.eigenstrain) and one.at is None and other.at is None

    for body in scene.bodies + scene.holes:
        for piece in body.pieces:
            if piece[0] == "line":
                along = np.subtract(piece[2], piece[1])
                is_parallel = abs(np.dot(along, left)) < 1e-9 * np.linalg.norm(along) and abs(np.dot(np.subtract(piece[1], tip.place), left)) < NEAR
                if is_parallel and distance(tip.place, piece) < NEAR:
                    if tip.crack.kind != "symmetry":
                        pair = [scene.material_at(tip.place + 1e-3 * side * left) for side in (1, -1)]
                        seam = seam or None in pair or not alike(*pair)
                    free = min(free, *(np.linalg.norm(np.subtract(end, tip.place)) for end in piece[1:]))
                    continue
                if is_between(piece, body, scene, alike):
                    continue
            free = min(free, distance(tip.place, piece))
    for crack in scene.cracks:
        if crack is not tip.crack:
            free = min(free, crack.off(tip.place))
        else:
            free = min([free, *(distance(tip.place, ("line", *ends)) for ends in (crack.segments[:-1] if tip.end == "last" else crack.segments[1:]))])
    for one in scene.holds + scene.loads:
        if one.lower is not None and getattr(one, "kind", "hold") in ("hold", "point", "traction", "pressure"):
            at = np.clip(tip.place, one.lower, one.upper)
            if tip.crack.kind != "symmetry" or np.linalg.norm(at - tip.place) > NEAR:
                free = min(free, np.linalg.norm(at - tip.place))
    if mine is not None and mine.at is not None:
        kinks = [abs(tip.place @ mine.direction - at) for at in mine.at]
        free = min([free, *(kink for kink in kinks if kink > 1e-6)])
        if min(kinks) < 1e-6:
            free = 0.0
    if scene.ring:
        free = min(free, tip.place[0])
    return free, seam


def is_between(piece, body, scene, alike):
    """Whether an edge of a body is all along that of another body of the same material."""
    along = np.subtract(piece[2], piece[1])
    across = 1e-3 * left_of(unit(along))
    for part in (0.02, 0.5, 0.98):
        pair = [scene.material_at(piece[1] + part * along + side * across) for side in (1, -1)]
        if None in pair or not alike(*pair):
            return False
    return True


def hang_together(pairs, count):
    """The number of the group of each of `count` things, of which pairs hang together."""
    first, second = np.transpose(pairs)
    return connected_components(coo_array((np.ones(len(first)), (first, second)), (count, count)), directed=False)[1]


def parted(triangles, cut):
    """The triangles with nodes of their own on both sides of the edges `cut`, and of which node each new one is a copy."""
    by_edge, copies, new = defaultdict(list), [], triangles.ravel().copy()
    for t, nodes in enumerate(triangles):
        for k in range(3):
            by_edge[frozenset((nodes[k], nodes[k - 1]))].append({nodes[k]: 3 * t + k, nodes[k - 1]: 3 * t + (k - 1) % 3})
    groups = hang_together([(near[0][node], near[1][node]) for edge, near in by_edge.items() if len(near) == 2 and edge not in cut for node in edge], len(new))
    for node in {node for edge in cut for node in edge}:
        corners = np.flatnonzero(triangles.ravel() == node)
        for group in np.unique(groups[corners])[1:]:
            new[corners[groups[corners] == group]] = triangles.max() + 1 + len(copies)
            copies.append(node)
    return new.reshape(-1, 3), copies


def build(scene):
    """The mesh of a scene."""
    tips = [tip for crack in scene.cracks for tip in crack.tips]
    found = [room_of(tip, scene) for tip in tips]
    geometry = Geometry(scene)
    raw = geometry.elements([room for room, _ in found])
    places = np.array(raw.Coordinates())[:, :2]
    triangles = np.array([[v.nr - 1 for v in one.vertices] for one in raw.Elements2D()])
    edges = {frozenset(v.nr - 1 for v in one.vertices) for one in raw.Elements1D()}
    owners = defaultdict(list)
    for t, nodes in enumerate(triangles):
        for k in range(3):
            pair = frozenset((nodes[k], nodes[(k + 1) % 3]))
            if pair in edges:
                owners[pair].append((t, k))
    number = {pair: next((k for k, crack in enumerate(scene.cracks) if crack.kind != "symmetry" and crack.off(places[list(pair)].mean(0)) < NEAR), None)
              for pair, near in owners.items() if len(near) == 2}
    new, copies = parted(triangles, {pair for pair, crack in number.items() if crack is not None})
    places = np.vstack([places, places[copies]]) if copies else places
    if len(np.unique(hang_together(np.vstack([new[:, :2], new[:, 1:]]), len(places))[new])) > 1:
        raise Outside("bodies, or parts of one, that do not hang together")
    mesh, parts, names = netgen.Mesh(dim=2), {}, {}
    ids = [mesh.Add(netgen.MeshPoint(netgen.Pnt(*place, 0))) for place in places]
    middles = places[new].mean(1)
    for nodes, middle in zip(new, middles):
        key = (next(k for k, body in enumerate(scene.bodies) if body.inside(middle)), *(tuple(k for k, one in enumerate(group) if one.lower is not None and wanted(one) and within(middle, one.lower, one.upper))
               for group, wanted in ((scene.holds, lambda one: True), (scene.loads, lambda one: one.kind == "body"))))
        if key not in parts:
            parts[key] = mesh.AddRegion(f"m{len(parts)}", dim=2)
        mesh.Add(netgen.Element2D(parts[key], [ids[n] for n in nodes]))
    arcs = [(k, piece) for k, piece in enumerate(scene.pieces()) if piece[0] == "arc"]
    for pair, near in owners.items():
        for t, k in near:
            key = edge_key(places[list(pair)], len(near) == 1, number.get(pair), middles[t], scene, arcs)
            if len(near) == 2 and key[2] is None and (not key[0] or t != near[0][0]):
                continue
            if key not in names:
                names[key] = mesh.AddRegion(f"b{len(names)}", dim=1)
            mesh.Add(netgen.Element1D([ids[new[t][k]], ids[new[t][(k + 1) % 3]]], index=names[key]))
    mesh = ng.Mesh(mesh)
    return Mesh(mesh, list(parts), list(names), [room for room, _ in found], [seam for _, seam in found], places, geometry.size)


def edge_key(ends, is_outer, crack, middle, scene, arcs):
    """What an edge is part of: holds, loads, its crack with the side, its arc."""
    at, arc = ends.mean(0), None
    if is_outer:
        for k, (_, centre, radius) in arcs:
            if max(distance(end, ("arc", centre, radius)) for end in ends) < 1e-5:
                arc = k
                at = centre + radius * (at - centre) / np.linalg.norm(at - centre)
    if crack is not None:
        return (), (), crack, "left" if (middle - at) @ left_of(scene.cracks[crack].along(middle)) > 0 else "right", None
    if scene.ring and max(ends[:, 0]) < NEAR:
        arc = AXIS
    holds = tuple(k for k, one in enumerate(scene.holds) if within(at, one.lower, one.upper))
    loads = tuple(k for k, one in enumerate(scene.loads) if is_outer and one.kind in ("traction", "pressure")
                  and (one.lower is None or within(at, one.lower, one.upper)) and (one.side is None or distance(at, one.side) < NEAR))
    return holds, loads, None, "", arc
