"""The input of commands on a mesh and its skeleton."""


def test_a_skeleton_from_a_file_gives_the_same_table(here):
    assert here("skeletonize", "rod.off", "-o", "rod.npz", "--quiet")[0] == 0
    made, read = here("branches", "rod.off"), here("branches", "rod.off", "--skeleton", "rod.npz")
    assert made == read
    assert len(made[1]) == 2


def test_a_skeleton_without_the_map_is_refused(here):
    here("skeletonize", "rod.off", "-o", "rod.swc", "--quiet")
    code, out, err = here("branches", "rod.off", "--skeleton", "rod.swc")
    assert (code, out) == (2, [])
    assert "rod.swc: maps 0 vertices to its nodes, and rod.off has 152; write the skeleton" in err[0]
