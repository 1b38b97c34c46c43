"""One word, one meaning: public names, report keys and options consist of the glossary's words and plain English."""

import inspect
import re
from pathlib import Path

import pytest

import lbskel
from lbskel.cli.main import command_line_parser
from lbskel.shapes import torus

GLOSSARY = Path(__file__).parent.parent / ".github" / "CONTRIBUTING.md"

# words of everyday technical English, which need no entry
PLAIN = """
a add advised after and angle angles area areas as assemble at attach b back batch bits box boxes broke c center chain
check choice closed cloud coarse compare complete compose contained contract count cut dask data deg degeneracy
degrees dependency diagonal dict distance distances edge edges error extend extension extra face faces fault fewest
file find findings finite first float force format forward from function graph grew ground grow growth h half help
highest html identity info initial input inputs inside int is iterate iterations join json k kind largest lbskel least
left length lengths like limit loops m many max mb mean measure measured measures megabytes memory merge merged mesh
method min missed missing n name neighbors networkx node nodes normals not note notes number o of on one only open
options order output parse part partition parts passed path per picture pictures place plain point points polygon
position prefix prepare prepared preprocess preprocessing profile progress quiet radii radius ratio reach read record
removed replace replaced report reports resample result rms row rows rule second seconds settings shape short shortest
simplify size skeleton skeletonize skeletons skipped smallest solve source sources spacing split square squares stage
start status step steps str strategies strong suffix surface surplus swc system target text thickness time timer title
to tolerance total translate treated type unit unknown upper used value values vertex vertices view volume where width
with within workers worst write x y z
"""


def words_of(name):
    """The words of an identifier or option, lower case."""
    return {word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)}


def glossary():
    """The words of all terms."""
    rows = re.findall(r"^\| ([^|]+) \| [^|]+ \|$", GLOSSARY.read_text(encoding="utf-8"), re.M)
    terms = [row for row in rows if row not in ("word", "---")]
    assert len(terms) > 50
    return set().union(*(words_of(term) for term in terms))


def is_known(word, known):
    """Whether a word, or what it is a plural or form of, is known."""
    stems = {word, word.removesuffix("s"), word.removesuffix("es"), word.removesuffix("ed"), word.removesuffix("d")}
    stems |= {word.removesuffix("ies") + "y", word.removesuffix("ion"), word.removesuffix("ing")}
    return bool(stems & known)


def keys(value):
    """All keys of nested dicts and lists."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from keys(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from keys(inner)


def names_and_parameters():
    for name in lbskel.__all__:
        yield name
        if inspect.isfunction(getattr(lbskel, name)):
            yield from inspect.signature(getattr(lbskel, name)).parameters


def report_keys():
    report = lbskel.skeletonize(torus(1.0, 0.3), profile=True).report
    return keys({key: value for key, value in report.items() if key != "versions"})  # versions: names of packages


def options():
    commands = command_line_parser()._subparsers._group_actions[0].choices
    for name, parser in commands.items():
        yield name
        for action in parser._actions:
            yield from (option.lstrip("-") for option in action.option_strings)


@pytest.mark.parametrize("names", [names_and_parameters, report_keys, options], ids=lambda names: names.__name__)
def test_every_word_is_of_the_glossary_or_plain_english(names):
    known = set(PLAIN.split()) | glossary()
    unknown = {name: sorted(word for word in words_of(name) if not is_known(word, known)) for name in names()}
    assert {name: words for name, words in unknown.items() if words} == {}


def test_a_private_word_is_found():
    assert not is_known("wayward", set(PLAIN.split()) | glossary())
    assert words_of("is_at_theWall") == {"is", "at", "the", "wall"}
