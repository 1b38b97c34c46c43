"""Curves in which planes cut a mesh: one curve for each plane is selected and measured.

A curve has a segment in each face that is cut and a point on each edge that is cut; segments that share a point belong
to one curve. A point is exactly the same for all faces at its edge, so winding numbers around the query are integers.
"""

from __future__ import annotations

__all__ = ["SectionCurves"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython
if cython.compiled:
    from cython.cimports.libc.math import atan2, fabs, sqrt
else:
    from math import atan2, fabs, sqrt

LEAF = cython.declare(cython.Py_ssize_t, 4)  # faces in a leaf, as in bvh
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # length of a traversal stack, as in bvh
FIRST_REACH = cython.declare(cython.double, 1.5)  # first search radius, in distances to a nearby vertex; for speed
MAX_REACH = cython.declare(cython.double, 4.0)  # search radius for a curve around, in lengths of a nearer one (a guess)
REACH_GROWTH = cython.declare(cython.double, 2.0)  # factor on the search radius while the curve is undecided (a guess)
CLOSURE_TOLERANCE = cython.declare(cython.double, 1e-6)  # gap / length of a closed curve: rounding (a guess)
MIN_COMPACTNESS = cython.declare(cython.double, 1e-12)  # area / length^2 for an area centroid (a guess)
FULL_TURN = cython.declare(cython.double, 2 * np.pi)
INFINITY = cython.declare(cython.double, float("inf"))
EMPTY = cython.declare(cython.double, 1e150)  # coordinate of boxes without faces, as in bvh

LENGTH = cython.declare(cython.Py_ssize_t, 0)  # columns of the sums over a curve: its length
CROSS = cython.declare(cython.Py_ssize_t, 1)  # cross products: twice the area
TURNS = cython.declare(cython.Py_ssize_t, 2)  # signed crossings of the first axis: the winding number
DISPLACEMENT = cython.declare(cython.Py_ssize_t, 3)  # from its first point to its last; two columns
AREA_MOMENT = cython.declare(cython.Py_ssize_t, 5)  # twice the midpoints times cross products; two columns
LENGTH_MOMENT = cython.declare(cython.Py_ssize_t, 7)  # twice the midpoints times lengths; two columns
OWN_LENGTH = cython.declare(cython.Py_ssize_t, 9)  # length on faces of the label, or of a negative one
MIN_DISTANCE = cython.declare(cython.Py_ssize_t, 10)  # squared distance to the query point
IS_COMPLETE = cython.declare(cython.Py_ssize_t, 11)  # 1 if all faces at its points were cut, else 0
ANGLE = cython.declare(cython.Py_ssize_t, 12)  # by which it turns around the query point, if it is not closed
N_SUMS = cython.declare(cython.Py_ssize_t, 13)


@cython.final
@cython.cclass
class SectionCurves:
    """Plane sections of a mesh; its arrays, those of :mod:`lbskel._kernels.bvh`, and a label for each face, or none."""

    edge_of_half_edge: cython.const[cython.longlong][::1]
    faces_per_edge: cython.const[cython.longlong][::1]
    order: cython.const[cython.longlong][::1]
    corners: cython.const[cython.double][:, ::1]
    boxes: cython.const[cython.double][:, ::1]
    labels: cython.const[cython.longlong][::1]
    point: cython.const[cython.double][::1]  # the query point
    a: cython.double  # the normal (a, b, c), and below two unit vectors in the plane
    b: cython.double
    c: cython.double
    offset: cython.double
    frame: cython.const[cython.double][:, ::1]
    stack: cython.longlong[::1]
    is_everything_cut: cython.bint  # whether no box that meets the plane was beyond the reach
    n_segments: cython.Py_ssize_t
    n_points: cython.Py_ssize_t
    point_of_edge: cython.longlong[::1]
    edge_of_point: cython.longlong[::1]
    segment_of_point: cython.longlong[::1]
    faces_at_point: cython.longlong[::1]
    points_2d: cython.double[:, ::1]
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
        # as long as can be needed; the system allocates only the pages that are written
        self.point_of_edge = np.zeros(n_edges, dtype=np.int64)
        self.edge_of_point, self.segment_of_point = np.empty_like(self.point_of_edge), np.empty_like(self.point_of_edge)
        self.faces_at_point, self.points_2d = np.empty_like(self.point_of_edge), np.empty((n_edges, 2))
        self.face_of_segment, self.start = np.empty(m, dtype=np.int64), np.empty(m, dtype=np.int64)
        self.stop, self.parent = np.empty(m, dtype=np.int64), np.empty(m, dtype=np.int64)
        self.stack, self.sums = np.empty(DEPTH, dtype=np.int64), np.empty((m, N_SUMS))

    @cython.locals(i=cython.Py_ssize_t, best=cython.Py_ssize_t, reach=cython.double, searched=cython.double)
    def measure(
        self,
        points: cython.const[cython.double][:, ::1],
        frames: cython.const[cython.double][:, :, ::1],
        labels: cython.const[cython.longlong][::1],
        max_reaches: cython.const[cython.double][::1],
    ) -> NDArray[np.float64]:
        """(k, 8) measures of the curve selected in the plane through each point, if it is decided within a reach of it.

        The frames are two unit vectors in each plane, and its normal. The measures are 1 if there is a curve, 1 if it
        surrounds the point, the two plane coordinates of its centroid relative to the point, its area, length and mean
        distance from the centroid, and the fraction of its length on faces of the plane's label or a negative one.
        """
        k: cython.Py_ssize_t = points.shape[0]
        if frames.shape[0] != k or labels.shape[0] != k or max_reaches.shape[0] != k:
            raise ValueError("there must be a frame, a label and a reach for each point")
        measures_array = np.zeros((k, 8))
        measures: cython.double[:, ::1] = measures_array
        with cython.nogil:
            for i in range(k):
                self.point, self.frame, self.n_segments, self.n_points, searched = points[i], frames[i], 0, 0, -1.0
                self.a, self.b, self.c = frames[i, 2, 0], frames[i, 2, 1], frames[i, 2, 2]
                self.offset = self.a * points[i, 0] + self.b * points[i, 1] + self.c * points[i, 2]
                reach = FIRST_REACH * self._distance_to_nearby_vertex() or INFINITY  # 0 at a vertex
                while True:
                    reach = min(reach, max_reaches[i])
                    self._cut_within(reach * reach, searched)
                    self._sum_curves(labels[i])
                    best = self._best()
                    if self.is_everything_cut or (best >= 0 and self._is_decided(best, reach)):
                        if best >= 0:
                            self._write_measures(best, measures[i])
                        break
                    if reach >= max_reaches[i]:
                        break
                    searched, reach = reach * reach, REACH_GROWTH * reach
        return measures_array

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    @cython.locals(axis=cython.Py_ssize_t, below=cython.double, above=cython.double, doubled=cython.double)
    def _box_distance(self, node: cython.Py_ssize_t) -> cython.double:
        """Squared distance from the query point to a box; absolute values in place of branches, for speed."""
        total: cython.double = 0.0
        for axis in range(3):
            below, above = self.boxes[node, axis] - self.point[axis], self.point[axis] - self.boxes[node, axis + 3]
            doubled = (below + fabs(below)) + (above + fabs(above))
            total += doubled * doubled
        return 0.25 * total

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _meets(self, node: cython.Py_ssize_t) -> cython.bint:
        """Whether the plane intersects a box."""
        x: cython.double = (self.boxes[node, 0] + self.boxes[node, 3]) / 2
        y: cython.double = (self.boxes[node, 1] + self.boxes[node, 4]) / 2
        z: cython.double = (self.boxes[node, 2] + self.boxes[node, 5]) / 2
        dx: cython.double = self.boxes[node, 3] - x
        dy: cython.double = self.boxes[node, 4] - y
        dz: cython.double = self.boxes[node, 5] - z
        height: cython.double = self.a * x + self.b * y + self.c * z - self.offset
        return fabs(height) <= fabs(self.a) * dx + fabs(self.b) * dy + fabs(self.c) * dz

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _distance_to_nearby_vertex(self) -> cython.double:
        """Distance from the query point to a vertex in the leaf found by descending to the nearer child."""
        p: cython.Py_ssize_t = self.boxes.shape[0] // 2
        node: cython.Py_ssize_t = 1
        while node < p:
            node *= 2
            if self.boxes[node + 1, 0] < EMPTY and self._box_distance(node + 1) < self._box_distance(node):
                node += 1
        row: cython.Py_ssize_t = (node - p) * LEAF
        dx: cython.double = self.corners[row, 0] - self.point[0]
        dy: cython.double = self.corners[row, 1] - self.point[1]
        dz: cython.double = self.corners[row, 2] - self.point[2]
        return sqrt(dx * dx + dy * dy + dz * dz)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    @cython.locals(node=cython.Py_ssize_t, row=cython.Py_ssize_t, distance=cython.double)
    def _cut_within(self, squared_reach: cython.double, searched: cython.double) -> cython.void:
        """Cut the faces in boxes up to a squared distance of the query point, but those cut by an earlier search."""
        p: cython.Py_ssize_t = self.boxes.shape[0] // 2
        top: cython.Py_ssize_t = 1
        self.stack[0], self.is_everything_cut = 1, True
        while top > 0:
            top, node = top - 1, self.stack[top - 1]
            if self.boxes[node, 0] >= EMPTY or not self._meets(node):
                continue
            distance = self._box_distance(node)
            if distance > squared_reach:
                self.is_everything_cut = False
            elif node < p:
                self.stack[top], self.stack[top + 1] = 2 * node, 2 * node + 1
                top += 2
            elif distance > searched:
                for row in range((node - p) * LEAF, min((node - p + 1) * LEAF, self.order.shape[0])):
                    self._cut_face(row)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _height(self, row: cython.Py_ssize_t, x: cython.Py_ssize_t) -> cython.double:
        """Signed height above the plane of the corner in columns from x; exactly the same for all faces at a vertex."""
        height: cython.double = self.a * self.corners[row, x] + self.b * self.corners[row, x + 1]
        return height + self.c * self.corners[row, x + 2] - self.offset

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _cut_face(self, row: cython.Py_ssize_t) -> cython.void:
        """Add the segment in a face that the plane cuts, counterclockwise if faces are oriented outwards."""
        first: cython.bint = self._height(row, 0) >= 0
        second: cython.bint = self._height(row, 3) >= 0
        third: cython.bint = self._height(row, 6) >= 0
        if first == second and second == third:
            return
        face: cython.longlong = self.order[row]
        single: cython.Py_ssize_t = 0 if second == third else 1 if third == first else 2  # alone on its side
        is_above: cython.bint = first if single == 0 else second if single == 1 else third
        left: cython.Py_ssize_t = (single + 1) % 3
        right: cython.Py_ssize_t = (single + 2) % 3
        left_edge: cython.longlong = self.edge_of_half_edge[right * self.order.shape[0] + face]
        right_edge: cython.longlong = self.edge_of_half_edge[left * self.order.shape[0] + face]
        segment: cython.Py_ssize_t = self.n_segments
        self.n_segments += 1
        self.parent[segment], self.face_of_segment[segment] = segment, face
        if is_above:
            self.start[segment] = self._point_on_edge(left_edge, row, left, single)
            self.stop[segment] = self._point_on_edge(right_edge, row, right, single)
        else:
            self.start[segment] = self._point_on_edge(right_edge, row, single, right)
            self.stop[segment] = self._point_on_edge(left_edge, row, single, left)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _point_on_edge(
        self, edge: cython.longlong, row: cython.Py_ssize_t, low: cython.Py_ssize_t, high: cython.Py_ssize_t
    ) -> cython.longlong:
        """Point on an edge between its corners below and above the plane; the last segment joins the curves there."""
        segment: cython.Py_ssize_t = self.n_segments - 1
        point: cython.longlong = self.point_of_edge[edge]
        if point < self.n_points and self.edge_of_point[point] == edge:
            self.faces_at_point[point] += 1
            other: cython.Py_ssize_t = self._curve(self.segment_of_point[point])
            self.parent[max(other, self._curve(segment))] = min(other, self._curve(segment))
            return point
        point, self.n_points = self.n_points, self.n_points + 1
        self.point_of_edge[edge], self.edge_of_point[point] = point, edge
        self.segment_of_point[point], self.faces_at_point[point] = segment, 1
        low, high = 3 * low, 3 * high
        height: cython.double = self._height(row, low)
        t: cython.double = height / (height - self._height(row, high))
        x: cython.double = (1 - t) * self.corners[row, low] + t * self.corners[row, high] - self.point[0]
        y: cython.double = (1 - t) * self.corners[row, low + 1] + t * self.corners[row, high + 1] - self.point[1]
        z: cython.double = (1 - t) * self.corners[row, low + 2] + t * self.corners[row, high + 2] - self.point[2]
        self.points_2d[point, 0] = self.frame[0, 0] * x + self.frame[0, 1] * y + self.frame[0, 2] * z
        self.points_2d[point, 1] = self.frame[1, 0] * x + self.frame[1, 1] * y + self.frame[1, 2] * z
        return point

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _curve(self, segment: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Curve of a segment, which is the number of its first segment; union and find."""
        while self.parent[segment] != segment:
            self.parent[segment] = self.parent[self.parent[segment]]
            segment = self.parent[segment]
        return segment

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    @cython.locals(segment=cython.Py_ssize_t, curve=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    def _sum_curves(self, label: cython.longlong) -> cython.void:
        """Sum over each complete curve, in the row of its first segment."""
        for segment in range(self.n_segments):
            if self.parent[segment] == segment:
                self.sums[segment] = 0
                self.sums[segment, MIN_DISTANCE], self.sums[segment, IS_COMPLETE] = INFINITY, 1
        for i in range(self.n_points):
            if self.faces_at_point[i] < self.faces_per_edge[self.edge_of_point[i]]:
                self.sums[self._curve(self.segment_of_point[i]), IS_COMPLETE] = 0
        for segment in range(self.n_segments):
            curve = self._curve(segment)
            if self.sums[curve, IS_COMPLETE] > 0:
                self._add_segment(segment, curve, label)
        for segment in range(self.n_segments):
            curve = self._curve(segment)
            if self.sums[curve, IS_COMPLETE] > 0 and not self._is_closed(curve):
                i, j = self.start[segment], self.stop[segment]
                self.sums[curve, ANGLE] += atan2(
                    self.points_2d[i, 0] * self.points_2d[j, 1] - self.points_2d[i, 1] * self.points_2d[j, 0],
                    self.points_2d[i, 0] * self.points_2d[j, 0] + self.points_2d[i, 1] * self.points_2d[j, 1],
                )

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    @cython.locals(ax=cython.double, ay=cython.double, bx=cython.double, by=cython.double)
    @cython.locals(dx=cython.double, dy=cython.double, x=cython.double, y=cython.double)
    def _add_segment(self, segment: cython.Py_ssize_t, curve: cython.Py_ssize_t, label: cython.longlong) -> cython.void:
        """Add a segment to the sums of its curve; area and centroid follow by Green's theorem."""
        ax, ay = self.points_2d[self.start[segment], 0], self.points_2d[self.start[segment], 1]
        bx, by = self.points_2d[self.stop[segment], 0], self.points_2d[self.stop[segment], 1]
        dx, dy = bx - ax, by - ay
        cross: cython.double = ax * by - ay * bx
        length: cython.double = sqrt(dx * dx + dy * dy)
        t: cython.double = min(max(-(ax * dx + ay * dy) / (length * length), 0.0), 1.0) if length > 0 else 0.0
        x, y = ax + t * dx, ay + t * dy
        self.sums[curve, LENGTH] += length
        self.sums[curve, CROSS] += cross
        self.sums[curve, DISPLACEMENT] += dx
        self.sums[curve, DISPLACEMENT + 1] += dy
        self.sums[curve, AREA_MOMENT] += (ax + bx) * cross
        self.sums[curve, AREA_MOMENT + 1] += (ay + by) * cross
        self.sums[curve, LENGTH_MOMENT] += (ax + bx) * length
        self.sums[curve, LENGTH_MOMENT + 1] += (ay + by) * length
        self.sums[curve, MIN_DISTANCE] = min(self.sums[curve, MIN_DISTANCE], x * x + y * y)
        self.sums[curve, TURNS] += 1 if ay <= 0 < by and cross > 0 else -1 if by <= 0 < ay and cross < 0 else 0
        if self.labels.shape[0] > 0:
            face_label: cython.longlong = self.labels[self.face_of_segment[segment]]
            if face_label == label or face_label < 0:
                self.sums[curve, OWN_LENGTH] += length

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _is_closed(self, curve: cython.Py_ssize_t) -> cython.bint:
        """Whether the segments of a curve sum to zero, up to rounding."""
        dx: cython.double = self.sums[curve, DISPLACEMENT]
        dy: cython.double = self.sums[curve, DISPLACEMENT + 1]
        return sqrt(dx * dx + dy * dy) < CLOSURE_TOLERANCE * self.sums[curve, LENGTH]

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _surrounds(self, curve: cython.Py_ssize_t) -> cython.bint:
        """Whether a curve winds around the query point by more than half a turn."""
        if self._is_closed(curve):
            return self.sums[curve, TURNS] != 0
        return fabs(self.sums[curve, ANGLE]) > FULL_TURN / 2

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _is_decided(self, curve: cython.Py_ssize_t, reach: cython.double) -> cython.bint:
        """Whether no farther search is needed: the complete curve surrounds the point, or is small and near."""
        size: cython.double = sqrt(self.sums[curve, MIN_DISTANCE]) + self.sums[curve, LENGTH]
        return self._surrounds(curve) or reach > MAX_REACH * size

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    @cython.locals(curve=cython.Py_ssize_t, best=cython.Py_ssize_t, size=cython.double, least=cython.double)
    def _best(self) -> cython.Py_ssize_t:
        """Smallest complete curve around the query point, or else the nearest; -1 if there is none."""
        best, least = -1, INFINITY
        is_around: cython.bint = False
        for curve in range(self.n_segments):
            if self.parent[curve] == curve and self.sums[curve, IS_COMPLETE] > 0:
                surrounds: cython.bint = self._surrounds(curve)
                size = fabs(self.sums[curve, CROSS]) if surrounds else self.sums[curve, MIN_DISTANCE]
                if surrounds > is_around or (surrounds == is_around and size < least):
                    best, is_around, least = curve, surrounds, size
        return best

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    @cython.locals(segment=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    @cython.locals(x=cython.double, y=cython.double, total=cython.double)
    def _write_measures(self, curve: cython.Py_ssize_t, out: cython.double[::1]) -> cython.void:
        """Write the eight measures of the selected curve."""
        area: cython.double = self.sums[curve, CROSS] / 2
        length: cython.double = self.sums[curve, LENGTH]
        x = y = total = 0.0
        if self._is_closed(curve) and fabs(area) > MIN_COMPACTNESS * length * length:
            x, y = self.sums[curve, AREA_MOMENT] / (6 * area), self.sums[curve, AREA_MOMENT + 1] / (6 * area)
        elif length > 0:
            x, y = self.sums[curve, LENGTH_MOMENT] / (2 * length), self.sums[curve, LENGTH_MOMENT + 1] / (2 * length)
        for segment in range(curve, self.n_segments):
            if self._curve(segment) == curve:
                i, j = self.start[segment], self.stop[segment]
                dx: cython.double = self.points_2d[j, 0] - self.points_2d[i, 0]
                dy: cython.double = self.points_2d[j, 1] - self.points_2d[i, 1]
                mx: cython.double = (self.points_2d[i, 0] + self.points_2d[j, 0]) / 2 - x
                my: cython.double = (self.points_2d[i, 1] + self.points_2d[j, 1]) / 2 - y
                total += sqrt(dx * dx + dy * dy) * sqrt(mx * mx + my * my)
        out[0], out[1], out[2], out[3], out[4], out[5] = 1, self._surrounds(curve), x, y, fabs(area), length
        if length > 0:
            out[6], out[7] = total / length, self.sums[curve, OWN_LENGTH] / length if self.labels.shape[0] > 0 else 1.0
