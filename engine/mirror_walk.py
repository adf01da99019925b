"""Walking a mesh and its mirror image at the same time."""

from __future__ import annotations

from dataclasses import dataclass

from engine.mesh import IntArray


@dataclass(frozen=True)
class Polygons:
    """Faces of any number of corners: ``loops`` their vertices in turn, ``edges`` (from, to) -> (face, corner)."""

    loops: list[list[int]]
    edges: dict[tuple[int, int], tuple[int, int]]

    @classmethod
    def of(cls, loops: list[list[int]]) -> Polygons:
        """Return polygons with their edges; of an edge that two faces run along in one direction the first counts."""
        edges: dict[tuple[int, int], tuple[int, int]] = {}
        for face, loop in enumerate(loops):
            before = loop[-1]
            for corner, vertex in enumerate(loop):
                edges.setdefault((before, vertex), (face, corner))
                before = vertex
        return cls(loops, edges)

    @classmethod
    def triangles(cls, faces: IntArray) -> Polygons:
        """Return the triangles (F, 3) as they are."""
        return cls.of(faces.tolist())


def fan_polygons(faces: IntArray, most: int = 4) -> Polygons:
    """Return polygons of up to ``most`` corners that were cut into fans: triangles a b c, a c d, ... in turn."""
    same = (faces[1:, 0] == faces[:-1, 0]) & (faces[1:, 1] == faces[:-1, 2])
    loops: list[list[int]] = []
    for follows, triangle in zip([False, *same.tolist()], faces.tolist(), strict=True):
        if follows and len(loops[-1]) < most and triangle[2] not in loops[-1]:
            loops[-1].append(triangle[2])
        else:
            loops.append(triangle)
    return Polygons.of(loops)


def paired_polygons(faces: IntArray) -> Polygons:
    """Return quadrilaterals of two triangles that follow each other and share an edge, however they begin."""
    loops: list[list[int]] = []
    waiting: list[int] | None = None
    for triangle in faces.tolist():
        if waiting is None:
            waiting = triangle
            continue
        quad = _quad(waiting, triangle)
        if quad is None:
            loops.append(waiting)
            waiting = triangle
        else:
            loops.append(quad)
            waiting = None
    if waiting is not None:
        loops.append(waiting)
    return Polygons.of(loops)


def _quad(one: list[int], two: list[int]) -> list[int] | None:
    for k in range(3):
        a, b, c = one[k], one[(k + 1) % 3], one[(k + 2) % 3]
        for j in range(3):
            if two[j] == b and two[(j + 1) % 3] == a and two[(j + 2) % 3] != c:
                return [c, a, two[(j + 2) % 3], b]
    return None


def walk(polygons: Polygons, start: int, image: list[int]) -> dict[int, int] | None:
    """Return the vertex on the other side of every vertex that is connected with face ``start``.

    Parameters
    ----------
    polygons : Polygons
        The mesh.
    start : int
        A face.
    image : list of int
        The vertices on the other side of its corners.

    Returns
    -------
    dict of int to int or None
        None where the two sides are not connected alike: a face of other corners, an edge without a partner, a vertex
        with two.
    """
    loops, edges = polygons.loops, polygons.edges
    loop = loops[start]
    pairs: dict[int, int] = {}

    def met(vertex: int, other: int) -> bool:
        return pairs.setdefault(vertex, other) == other and pairs.setdefault(other, vertex) == vertex

    if len(set(image)) < len(image) or not all(map(met, loop, image)):
        return None
    seen: set[int] = set()
    waiting = [(loop[-1], loop[0])]
    while waiting:
        u, v = waiting.pop()
        here, there = edges.get((u, v)), edges.get((pairs[v], pairs[u]))
        if (here is None) != (there is None):
            return None
        if here is None or there is None or here[0] in seen:
            continue
        seen.add(here[0])
        one, two = loops[here[0]], loops[there[0]]
        size = len(one)
        if size != len(two):
            return None
        # Behind u -> v follow w1 .. wk; in the image, which runs the other way round, they come last first.
        forward = [one[(here[1] + k) % size] for k in range(size)]
        backward = [two[(there[1] - 1 - k) % size] for k in range(size)]
        if not all(map(met, forward, backward)):
            return None
        before = forward[-1]
        for vertex in forward:
            waiting.append((vertex, before))
            before = vertex
    return pairs
