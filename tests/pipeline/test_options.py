"""Options: what is given comes before the domain's, that before the defaults; no choice is refused."""

import pytest

from lbskel import DOMAINS, PRESETS, ContractionSettings, UnknownChoice, skeletonize
from lbskel.pipeline.options import JOIN, require_refinement_options, resolve_options, resolve_settings
from lbskel.shapes import chain_of_tori

NOTHING = dict.fromkeys(("min_branch_ratio", "tip_position", "join", "min_loop", "radius_kind"))


def test_the_defaults_are_those_of_every_preset():
    expected = {"min_branch_ratio": 1.5, "tip_position": "inside", "join": "pieces", "min_loop": 0.0}
    expected["radius_kind"] = "inscribed"
    for preset in (*PRESETS, ContractionSettings()):
        assert resolve_options(preset, NOTHING) == expected


@pytest.mark.parametrize("name", DOMAINS)
def test_a_domain_has_options_of_its_own_and_the_settings_of_the_default(name):
    options = resolve_options(name, NOTHING)
    assert DOMAINS[name]
    assert options != resolve_options("curvature_flow", NOTHING)
    assert options == resolve_options("curvature_flow", NOTHING) | dict(DOMAINS[name])
    assert resolve_settings(name, None, None, None) == PRESETS["curvature_flow"]
    assert resolve_settings(name, "robust", None, None).operator == "robust"


@pytest.mark.parametrize("name", DOMAINS)
def test_what_is_given_comes_before_what_the_domain_says(name):
    given = {"min_branch_ratio": 4.0, "tip_position": "inside", "join": "none", "min_loop": 0.0}
    given["radius_kind"] = "inscribed"
    assert resolve_options(name, given) == given


def test_a_domain_has_no_name_of_a_preset():
    assert not set(DOMAINS) & set(PRESETS)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"join": "some"}, "way to join"),
        ({"min_loop": -1.0}, "min_loop must be"),
        ({"min_loop": float("nan")}, "min_loop must be"),
        ({"tip_position": "middle"}, "tip position"),
        ({"radius_kind": "median"}, "kind of radius"),
        ({"min_branch_ratio": -1.0}, "min_branch_ratio must be"),
    ],
)
def test_what_is_no_choice_is_refused(given, message):
    with pytest.raises(UnknownChoice, match=message):
        resolve_options("curvature_flow", NOTHING | given)
    with pytest.raises(UnknownChoice, match=message):
        skeletonize("no such file", **given)  # before any work


def test_options_of_the_refinement_are_refused_alone_too():
    require_refinement_options(0.0, "surface")
    for bad in ((float("nan"), "inside"), (1.5, "pieces")):
        with pytest.raises(UnknownChoice):
            require_refinement_options(*bad)


def test_an_unknown_preset_names_the_presets_and_the_domains():
    with pytest.raises(UnknownChoice) as caught:
        resolve_settings("neurons", None, None, None)
    for name in (*PRESETS, *DOMAINS):
        assert name in str(caught.value)
    assert "pieces" in JOIN


def test_the_options_of_a_domain_reach_the_result(rod):
    """A vessel's loops of 4 pi radii are kept and those below 12 opened; the tips of a part are on its surface."""
    rings = chain_of_tori(2, step=0.2)
    length = skeletonize(rings).length
    assert skeletonize(rings, preset="neuron").cycle_rank == 0
    assert skeletonize(rings, preset="neuron").report["loops_opened"] == 2
    assert skeletonize(rings, preset="neuron", min_loop=0.0).cycle_rank == 2
    assert skeletonize(rings, preset="neuron", min_loop=0.0).length == length
    part, default = skeletonize(rod, preset="cad"), skeletonize(rod)
    span = [each.nodes[:, 2].max() - each.nodes[:, 2].min() for each in (part, default)]
    assert span[0] > span[1] + 0.4  # the radius of the rod, which its ends were short of twice
