# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The curves in which planes cut faces: found by a tree of boxes, joined by shared edges, one chosen and measured.

A curve has segments, one in each face cut, and ends, one on each edge cut; segments with an end in common are joined.
An end has the same coordinates for all its faces, so that a curve winds round a point a whole number of times.
"""

from __future__ import annotations

__all__ = ["Curves"]

import cython
import numpy as np
from cython.cimports.libc.math import atan2, fabs, sqrt
from numpy.typing import NDArray

LEAF = cython.declare(cython.Py_ssize_t, 4)  # faces
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # levels of any tree
NEAR = cython.declare(cython.double, 3.0)  # times the distance to something near: where a curve is looked for first
FARTHER = cython.declare(cython.double, 2.0)  # times as far is looked where that does not tell
CLOSED = cython.declare(cython.double, 1e-6)  # of a curve's length that its ends may be apart
FLAT = cython.declare(cython.double, 1e-12)  # of the square of its length that its area must have to have a centroid
TURN = cython.declare(cython.double, 2 * np.pi)
NEVER = cython.declare(cython.double, float("inf"))
NOWHERE = cython.declare(cython.double, 1e150)  # the place of boxes without a face, as in trees

LENGTH = cython.declare(cython.Py_ssize_t, 0)  # columns of the sums over a curve
CROSS = cython.declare(cython.Py_ssize_t, 1)  # products, twice the area
TURNS = cython.declare(cython.Py_ssize_t, 2)  # signed crossings of an axis
STEP = cython.declare(cython.Py_ssize_t, 3)  # from its first end to its last
BY_AREA = cython.declare(cython.Py_ssize_t, 5)  # twice the middles of its segments, times cross products
BY_LENGTH = cython.declare(cython.Py_ssize_t, 7)  # the same times lengths
OWN = cython.declare(cython.Py_ssize_t, 9)  # length on faces of the label
NEAREST = cython.declare(cython.Py_ssize_t, 10)  # least square of a distance from the point
WHOLE = cython.declare(cython.Py_ssize_t, 11)  # whether it runs on nowhere outside of what was looked at
SUMS = cython.declare(cython.Py_ssize_t, 12)


@cython.cclass
class Curves:
    """What planes cut out of a mesh; the arrays are those of a Mesh, its tree, and a label for each face or none."""

    edge_of_half_edge: cython.const[cython.longlong][::1]
    faces_per_edge: cython.const[cython.longlong][::1]
    order: cython.const[cython.longlong][::1]
    corners: cython.const[cython.double][:, ::1]
    boxes: cython.const[cython.double][:, ::1]
    labels: cython.const[cython.longlong][::1]
    x: cython.double  # the point, the normal, and two unit vectors in the plane
    y: cython.double
    z: cython.double
    a: cython.double
    b: cython.double
    c: cython.double
    offset: cython.double
    frame: cython.double[:, ::1]
    stack: cython.longlong[::1]
    is_all: cython.bint  # whether nothing of the plane was left out for being far
    n_segments: cython.Py_ssize_t
    n_ends: cython.Py_ssize_t
    end_of_edge: cython.longlong[::1]
    edge_of_end: cython.longlong[::1]
    segment_of_end: cython.longlong[::1]
    faces_at_end: cython.longlong[::1]
    ends: cython.double[:, ::1]
    face_of_segment: cython.longlong[::1]
    start: cython.longlong[::1]
    stop: cython.longlong[::1]
    parent: cython.longlong[::1]
    sums: cython.double[:, ::1]

    def __init__(
        self,
        edge_of_half_edge: NDArray[np.int64],
        faces_per_edge: NDArray[np.int64],
        order: NDArray[np.int64],
        corners: NDArray[np.float64],
        boxes: NDArray[np.float64],
        labels: NDArray[np.int64],
    ) -> None:
        m, n_edges = len(order), len(faces_per_edge)
        if len(labels) not in (0, m):
            raise ValueError("there must be a label for each face")
        self.edge_of_half_edge, self.faces_per_edge = edge_of_half_edge, faces_per_edge
        self.order, self.corners, self.boxes, self.labels = order, corners, boxes, labels
        self.frame, self.stack = np.empty((2, 3)), np.empty(DEPTH, dtype=np.int64)
        # as long as ever needed; memory is taken only where something is written
        self.end_of_edge = np.zeros(n_edges, dtype=np.int64)
        self.edge_of_end, self.segment_of_end = np.empty_like(self.end_of_edge), np.empty_like(self.end_of_edge)
        self.faces_at_end, self.ends = np.empty_like(self.end_of_edge), np.empty((n_edges, 2))
        self.face_of_segment, self.start = np.empty(m, dtype=np.int64), np.empty(m, dtype=np.int64)
        self.stop, self.parent = np.empty(m, dtype=np.int64), np.empty(m, dtype=np.int64)
        self.sums = np.empty((m, SUMS))

    @cython.locals(i=cython.Py_ssize_t, axis=cython.Py_ssize_t, best=cython.Py_ssize_t, reach=cython.double)
    def chosen(
        self,
        points: cython.const[cython.double][:, ::1],
        frames: cython.const[cython.double][:, :, ::1],
        labels: cython.const[cython.longlong][::1],
    ) -> NDArray[np.float64]:
        """(k, 8) of the curve chosen for each plane: whether it is one, whether it goes round the point, the centroid
        in the plane from there, area, length, mean distance from the centroid, and the share on faces of the label.

        Parameters
        ----------
        points : (k, 3) array of float
        frames : (k, 3, 3) array of float
            Of each plane two unit vectors in it, and its normal.
        labels : (k,) array of int
            Faces of this label, or of a negative one, are the curve's own.
        """
        k: cython.Py_ssize_t = points.shape[0]
        if frames.shape[0] != k or labels.shape[0] != k:
            raise ValueError("there must be a frame and a label for each point")
        chosen_array = np.zeros((k, 8))
        chosen: cython.double[:, ::1] = chosen_array
        for i in range(k):
            self.x, self.y, self.z = points[i, 0], points[i, 1], points[i, 2]
            self.a, self.b, self.c = frames[i, 2, 0], frames[i, 2, 1], frames[i, 2, 2]
            self.offset = self.a * self.x + self.b * self.y + self.c * self.z
            for axis in range(3):
                self.frame[0, axis], self.frame[1, axis] = frames[i, 0, axis], frames[i, 1, axis]
            reach = NEAR * self._distance_of_something_near()
            if not reach > 0:  # at a vertex
                reach = NEVER
            while True:
                self._cut_within(reach)
                self._sum_up(labels[i])
                best = self._best()
                if self.is_all or (best >= 0 and self.sums[best, WHOLE] > 0 and self._goes_round(best)):
                    break
                reach *= FARTHER
            if best >= 0:
                self._measure(best, chosen[i])
        return chosen_array

    @cython.cfunc
    @cython.exceptval(check=False)
    def _box_distance(self, node: cython.Py_ssize_t) -> cython.double:
        """The square of the distance of the point from a box."""
        dx: cython.double = max(max(self.boxes[node, 0] - self.x, self.x - self.boxes[node, 3]), 0.0)
        dy: cython.double = max(max(self.boxes[node, 1] - self.y, self.y - self.boxes[node, 4]), 0.0)
        dz: cython.double = max(max(self.boxes[node, 2] - self.z, self.z - self.boxes[node, 5]), 0.0)
        return dx * dx + dy * dy + dz * dz

    @cython.cfunc
    @cython.exceptval(check=False)
    def _meets(self, node: cython.Py_ssize_t) -> cython.bint:
        """Whether the plane meets a box."""
        x: cython.double = (self.boxes[node, 0] + self.boxes[node, 3]) / 2
        y: cython.double = (self.boxes[node, 1] + self.boxes[node, 4]) / 2
        z: cython.double = (self.boxes[node, 2] + self.boxes[node, 5]) / 2
        dx: cython.double = self.boxes[node, 3] - x
        dy: cython.double = self.boxes[node, 4] - y
        dz: cython.double = self.boxes[node, 5] - z
        height: cython.double = self.a * x + self.b * y + self.c * z - self.offset
        return fabs(height) <= fabs(self.a) * dx + fabs(self.b) * dy + fabs(self.c) * dz

    @cython.cfunc
    @cython.exceptval(check=False)
    def _distance_of_something_near(self) -> cython.double:
        """From the point to a vertex in the box found by going where it is nearer."""
        p: cython.Py_ssize_t = self.boxes.shape[0] // 2
        node: cython.Py_ssize_t = 1
        while node < p:
            node *= 2
            if self.boxes[node + 1, 0] < NOWHERE and self._box_distance(node + 1) < self._box_distance(node):
                node += 1
        at: cython.Py_ssize_t = (node - p) * LEAF
        dx: cython.double = self.corners[at, 0] - self.x
        dy: cython.double = self.corners[at, 1] - self.y
        dz: cython.double = self.corners[at, 2] - self.z
        return sqrt(dx * dx + dy * dy + dz * dz)

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(node=cython.Py_ssize_t, at=cython.Py_ssize_t)
    def _cut_within(self, reach: cython.double) -> cython.void:
        """Every segment in the boxes that are within reach of the point."""
        p: cython.Py_ssize_t = self.boxes.shape[0] // 2
        top: cython.Py_ssize_t = 1
        self.n_segments = self.n_ends = 0
        self.is_all = True
        self.stack[0] = 1
        while top > 0:
            top -= 1
            node = self.stack[top]
            if self.boxes[node, 0] >= NOWHERE or not self._meets(node):
                continue
            if self._box_distance(node) > reach * reach:
                self.is_all = False
            elif node < p:
                self.stack[top], self.stack[top + 1] = 2 * node, 2 * node + 1
                top += 2
            else:
                for at in range((node - p) * LEAF, min((node - p + 1) * LEAF, self.order.shape[0])):
                    self._cut_face(at)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _height(self, at: cython.Py_ssize_t, corner: cython.Py_ssize_t) -> cython.double:
        """Of a corner over the plane; the same for all faces at a vertex."""
        x: cython.double = self.corners[at, 3 * corner]
        y: cython.double = self.corners[at, 3 * corner + 1]
        z: cython.double = self.corners[at, 3 * corner + 2]
        return self.a * x + self.b * y + self.c * z - self.offset

    @cython.cfunc
    @cython.exceptval(check=False)
    def _cut_face(self, at: cython.Py_ssize_t) -> cython.void:
        """The segment in a face, if the plane cuts it, counter-clockwise round the normal where faces face outwards."""
        first: cython.bint = self._height(at, 0) >= 0
        second: cython.bint = self._height(at, 1) >= 0
        third: cython.bint = self._height(at, 2) >= 0
        if first == second and second == third:
            return
        m: cython.Py_ssize_t = self.order.shape[0]
        face: cython.longlong = self.order[at]
        lone: cython.Py_ssize_t = 0 if second == third else 1 if third == first else 2  # that one alone is on its side
        is_above: cython.bint = first if lone == 0 else second if lone == 1 else third
        left: cython.Py_ssize_t = (lone + 1) % 3
        right: cython.Py_ssize_t = (lone + 2) % 3
        segment: cython.Py_ssize_t = self.n_segments
        self.n_segments += 1
        self.parent[segment] = segment
        self.face_of_segment[segment] = face
        if is_above:
            self.start[segment] = self._end_on(self.edge_of_half_edge[right * m + face], segment, at, left, lone)
            self.stop[segment] = self._end_on(self.edge_of_half_edge[left * m + face], segment, at, right, lone)
        else:
            self.start[segment] = self._end_on(self.edge_of_half_edge[left * m + face], segment, at, lone, right)
            self.stop[segment] = self._end_on(self.edge_of_half_edge[right * m + face], segment, at, lone, left)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _end_on(
        self,
        edge: cython.longlong,
        segment: cython.Py_ssize_t,
        at: cython.Py_ssize_t,
        low: cython.Py_ssize_t,
        high: cython.Py_ssize_t,
    ) -> cython.longlong:
        """The end on an edge, from the corner under the plane to that above; who else has a segment there is joined."""
        end: cython.longlong = self.end_of_edge[edge]
        if end < self.n_ends and self.edge_of_end[end] == edge:
            self.faces_at_end[end] += 1
            self._join(self.segment_of_end[end], segment)
            return end
        end = self.n_ends
        self.n_ends += 1
        self.end_of_edge[edge], self.edge_of_end[end] = end, edge
        self.segment_of_end[end], self.faces_at_end[end] = segment, 1
        height: cython.double = self._height(at, low)
        share: cython.double = height / (height - self._height(at, high))
        low, high = 3 * low, 3 * high
        x: cython.double = (1 - share) * self.corners[at, low] + share * self.corners[at, high] - self.x
        y: cython.double = (1 - share) * self.corners[at, low + 1] + share * self.corners[at, high + 1] - self.y
        z: cython.double = (1 - share) * self.corners[at, low + 2] + share * self.corners[at, high + 2] - self.z
        self.ends[end, 0] = self.frame[0, 0] * x + self.frame[0, 1] * y + self.frame[0, 2] * z
        self.ends[end, 1] = self.frame[1, 0] * x + self.frame[1, 1] * y + self.frame[1, 2] * z
        return end

    @cython.cfunc
    @cython.exceptval(check=False)
    def _curve(self, segment: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """The curve that a segment is on: the first of its segments."""
        while self.parent[segment] != segment:
            self.parent[segment] = self.parent[self.parent[segment]]
            segment = self.parent[segment]
        return segment

    @cython.cfunc
    @cython.exceptval(check=False)
    def _join(self, i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> cython.void:
        """Make one curve of those of two segments."""
        i, j = self._curve(i), self._curve(j)
        self.parent[max(i, j)] = min(i, j)

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(segment=cython.Py_ssize_t, curve=cython.Py_ssize_t, end=cython.Py_ssize_t, at=cython.Py_ssize_t)
    def _sum_up(self, label: cython.longlong) -> cython.void:
        """The sums over each curve, in the row of its first segment."""
        for segment in range(self.n_segments):
            curve = self._curve(segment)
            if curve == segment:
                for at in range(SUMS):
                    self.sums[curve, at] = 0
                self.sums[curve, NEAREST], self.sums[curve, WHOLE] = NEVER, 1
            self._add(segment, curve, label)
        for end in range(self.n_ends):
            if self.faces_at_end[end] < self.faces_per_edge[self.edge_of_end[end]]:
                self.sums[self._curve(self.segment_of_end[end]), WHOLE] = 0

    @cython.cfunc
    @cython.exceptval(check=False)
    def _add(self, segment: cython.Py_ssize_t, curve: cython.Py_ssize_t, label: cython.longlong) -> cython.void:
        """A segment to the sums of its curve; area and centroid by Green's theorem."""
        ax: cython.double = self.ends[self.start[segment], 0]
        ay: cython.double = self.ends[self.start[segment], 1]
        bx: cython.double = self.ends[self.stop[segment], 0]
        by: cython.double = self.ends[self.stop[segment], 1]
        dx: cython.double = bx - ax
        dy: cython.double = by - ay
        cross: cython.double = ax * by - ay * bx
        length: cython.double = sqrt(dx * dx + dy * dy)
        share: cython.double = 0
        if length > 0:
            share = min(max(-(ax * dx + ay * dy) / (length * length), 0.0), 1.0)
        x: cython.double = ax + share * dx
        y: cython.double = ay + share * dy
        self.sums[curve, LENGTH] += length
        self.sums[curve, CROSS] += cross
        self.sums[curve, STEP] += dx
        self.sums[curve, STEP + 1] += dy
        self.sums[curve, BY_AREA] += (ax + bx) * cross
        self.sums[curve, BY_AREA + 1] += (ay + by) * cross
        self.sums[curve, BY_LENGTH] += (ax + bx) * length
        self.sums[curve, BY_LENGTH + 1] += (ay + by) * length
        self.sums[curve, NEAREST] = min(self.sums[curve, NEAREST], x * x + y * y)
        if ay <= 0 < by and cross > 0:
            self.sums[curve, TURNS] += 1
        elif by <= 0 < ay and cross < 0:
            self.sums[curve, TURNS] -= 1
        if self.labels.shape[0] > 0:
            face_label: cython.longlong = self.labels[self.face_of_segment[segment]]
            if face_label == label or face_label < 0:
                self.sums[curve, OWN] += length

    @cython.cfunc
    @cython.exceptval(check=False)
    def _is_closed(self, curve: cython.Py_ssize_t) -> cython.bint:
        """Whether the steps of a curve lead back to where it began."""
        dx: cython.double = self.sums[curve, STEP]
        dy: cython.double = self.sums[curve, STEP + 1]
        return sqrt(dx * dx + dy * dy) < CLOSED * self.sums[curve, LENGTH]

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(segment=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    def _goes_round(self, curve: cython.Py_ssize_t) -> cython.bint:
        """Whether a curve winds round the point by more than half a turn."""
        if self._is_closed(curve):
            return self.sums[curve, TURNS] != 0
        angle: cython.double = 0
        for segment in range(curve, self.n_segments):
            if self._curve(segment) == curve:
                i, j = self.start[segment], self.stop[segment]
                angle += atan2(
                    self.ends[i, 0] * self.ends[j, 1] - self.ends[i, 1] * self.ends[j, 0],
                    self.ends[i, 0] * self.ends[j, 0] + self.ends[i, 1] * self.ends[j, 1],
                )
        return fabs(angle) > TURN / 2

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(curve=cython.Py_ssize_t, rank=cython.Py_ssize_t, size=cython.double)
    def _best(self) -> cython.Py_ssize_t:
        """Of whole curves, or else of all, the smallest that goes round the point, or else the nearest; -1 if none."""
        best: cython.Py_ssize_t = -1
        best_rank: cython.Py_ssize_t = 4
        least: cython.double = NEVER
        for curve in range(self.n_segments):
            if self.parent[curve] != curve:
                continue
            goes_round: cython.bint = self._goes_round(curve)
            rank = (0 if self.sums[curve, WHOLE] > 0 else 2) + (0 if goes_round else 1)
            size = fabs(self.sums[curve, CROSS]) if goes_round else self.sums[curve, NEAREST]
            if rank < best_rank or (rank == best_rank and size < least):
                best, best_rank, least = curve, rank, size
        return best

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(segment=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    def _measure(self, curve: cython.Py_ssize_t, row: cython.double[::1]) -> cython.void:
        """What is told of the curve that was chosen."""
        area: cython.double = self.sums[curve, CROSS] / 2
        length: cython.double = self.sums[curve, LENGTH]
        x: cython.double = 0
        y: cython.double = 0
        if self._is_closed(curve) and fabs(area) > FLAT * length * length:
            x, y = self.sums[curve, BY_AREA] / (6 * area), self.sums[curve, BY_AREA + 1] / (6 * area)
        elif length > 0:
            x, y = self.sums[curve, BY_LENGTH] / (2 * length), self.sums[curve, BY_LENGTH + 1] / (2 * length)
        total: cython.double = 0
        for segment in range(curve, self.n_segments):
            if self._curve(segment) == curve:
                i, j = self.start[segment], self.stop[segment]
                dx: cython.double = self.ends[j, 0] - self.ends[i, 0]
                dy: cython.double = self.ends[j, 1] - self.ends[i, 1]
                mx: cython.double = (self.ends[i, 0] + self.ends[j, 0]) / 2 - x
                my: cython.double = (self.ends[i, 1] + self.ends[j, 1]) / 2 - y
                total += sqrt(dx * dx + dy * dy) * sqrt(mx * mx + my * my)
        row[0], row[1], row[2], row[3], row[4], row[5] = 1, self._goes_round(curve), x, y, fabs(area), length
        if length > 0:
            row[6] = total / length
            row[7] = self.sums[curve, OWN] / length if self.labels.shape[0] > 0 else 1.0
