"""Many meshes at once on a Dask cluster; a mesh that fails stops no other."""

from pathlib import Path

from distributed import LocalCluster

import lbskel
from lbskel.visualization import Panel, render

Path("broken.off").write_text("this is no mesh")
inputs = ["meshes/hand.ply", "meshes/knot.off", "broken.off"]
with LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster:  # or that of a computing center
    records = lbskel.skeletonize_many(inputs, "skeletons", dask=cluster.scheduler_address)

made = {record.input: Path("skeletons", record.output) for record in records if record.outcome == "passed"}
for record in records:
    print(f"{record.input}: {record.outcome.value} {record.message}")
panels = [Panel(lbskel.read_mesh(name), lbskel.read_skeleton(path), Path(name).stem) for name, path in made.items()]
render(panels, "batch_on_dask.png")
assert list(made) == inputs[:2]
