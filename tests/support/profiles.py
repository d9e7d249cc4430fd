"""Profiles for tests of their XML: any profile there can be, and whether a document has the structure it should."""

from functools import cache
from pathlib import Path

from hypothesis import strategies as st
from lxml import etree

from openrois.types.codes import ComponentFunction
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    HRIEngineProfile,
    ParameterProfile,
    QueryMessageProfile,
    RoISIdentifier,
)

__all__ = ["components", "engines", "structural_errors"]

_XSD_ID = "{http://www.opengis.net/gml/3.2}id"
_HRI_COMPONENT = "{http://www.omg.org/spec/RoIS/20240801}HRIComponent"

texts = st.text(st.characters(exclude_categories=("Cc", "Cs"), exclude_characters="\ufffe\uffff"), max_size=6)
attributes = texts | st.text("a \t\r\n&<>\"'", max_size=4)
references = st.text(min_size=1, max_size=8) | st.sampled_from(["engine.a", "none.a", "component_profile", "a/b"])
codes = (
    texts
    | st.sampled_from(["OMG", "", "Example"]).map("urn:x-rois:def:component:{}::Lamp".format)
    | st.just("urn:ietf:rfc:2141")
)
identifiers = st.builds(
    RoISIdentifier,
    code=codes,
    authority=texts | st.just("OMG"),
    codebook_ref=texts | st.sampled_from(["urn:ietf:rfc:2141", "urn:x-openrois:id", "http://example.org/codes#1"]),
    version=texts,
)
parameters = st.builds(
    ParameterProfile,
    name=attributes,
    data_type_ref=st.builds(
        RoISIdentifier, code=attributes, authority=attributes, codebook_ref=attributes, version=attributes
    ),
    default_value=attributes,
    description=attributes,
)
some = st.lists(parameters, max_size=2).map(tuple)
commands = st.builds(
    CommandMessageProfile,
    name=attributes,
    results=some,
    arguments=some,
    timeout=st.none() | st.integers(-(10**20) + 1, 10**20 - 1),
)
components = st.builds(
    HRIComponentProfile,
    identifier=identifiers,
    name=texts,
    function=st.none() | st.sampled_from(ComponentFunction),
    sub_component_profiles=st.lists(texts, max_size=2).map(tuple),
    command_profiles=st.lists(commands, max_size=2).map(tuple),
    query_profiles=st.lists(st.builds(QueryMessageProfile, name=attributes, results=some), max_size=2).map(tuple),
    event_profiles=st.lists(st.builds(EventMessageProfile, name=attributes, results=some), max_size=2).map(tuple),
    parameter_profiles=some,
)


@st.composite
def engines(draw: st.DrawFn) -> HRIEngineProfile:
    """Draw the profile of an engine whose ids stand once in its tree."""
    ids = iter(draw(st.lists(texts.filter(bool), min_size=7, max_size=7, unique=True)))
    refs = iter(draw(st.lists(references, min_size=14, max_size=14, unique=True)))

    def engine(depth: int) -> HRIEngineProfile:
        below = range(draw(st.integers(0, 2))) if depth else ()
        identifier = draw(identifiers)
        return HRIEngineProfile(
            identifier=identifier.model_copy(update={"code": next(ids)}),
            sub_profiles=tuple(engine(depth - 1) for _ in below),
            component_ids=tuple(next(refs) for _ in range(draw(st.integers(0, 2)))),
            parameter_profiles=draw(some),
        )

    return engine(2)


@cache
def _grammar() -> etree.RelaxNG:
    return etree.RelaxNG(etree.parse(Path(__file__).with_name("profiles.rng")))


def structural_errors(document: str) -> list[str]:
    """Return what is wrong with the structure of a document; each XML id may stand once."""
    tree = etree.fromstring(document.encode())
    grammar = _grammar()
    grammar.validate(tree)
    ids = [tree.get(_XSD_ID), *(each.get(_XSD_ID) for each in tree.iter("{*}SubProfile"))]
    ids += [each.text for each in tree.iter(_HRI_COMPONENT)]
    twice = [f"{each} stands twice" for each in set(ids) if ids.count(each) > 1]
    return [str(error.message) for error in grammar.error_log] + twice
