"""A point cloud without faces or normals."""

import lbskel
from lbskel.visualization import Panel, render

cloud = lbskel.PointCloud(lbskel.read_mesh("meshes/hand.ply").vertices)
skeleton = lbskel.skeletonize(cloud)
surface = lbskel.reconstruct_surface(cloud)
render(
    [Panel(cloud, title="points"), Panel(surface.mesh, title="surface"), Panel(cloud, skeleton, "skeleton")],
    "points.png",
)

print(*skeleton.report["notes"], sep="\n")
assert len(skeleton.node_of_vertex) == len(cloud.points)
assert len(skeleton.tips) == 6
