"""Components by engine, name and type, so that a search looks at few of many. Pure."""

from collections.abc import Collection, Sequence
from itertools import count

from openrois.engine.condition import Comparison, Condition
from openrois.types.profiles import HRIComponentProfile
from openrois.types.references import engine_of

__all__ = ["ComponentIndex"]

_Refs = dict[str, None]
"""An ordered set."""

_Groups = Sequence[Collection[str]]
"""Components that have something in common, or several of such."""


class ComponentIndex:
    """References of components, in the order in which they came."""

    def __init__(self) -> None:
        self._places: dict[str, int] = {}
        """The place of each component in the order."""
        self._numbers = count()
        self._by_engine: dict[str, _Refs] = {}
        self._by_name: dict[str, _Refs] = {}
        self._by_type: dict[str, _Refs] = {}

    def add(self, component_ref: str, profile: HRIComponentProfile) -> None:
        """Add a component that is not there."""
        self._places[component_ref] = next(self._numbers)
        for refs, key in self._keys(component_ref, profile):
            refs.setdefault(key, {})[component_ref] = None

    def remove(self, component_ref: str, profile: HRIComponentProfile) -> None:
        """Remove a component that is there with this profile."""
        del self._places[component_ref]
        for refs, key in self._keys(component_ref, profile):
            del refs[key][component_ref]
            if not refs[key]:
                del refs[key]

    def _keys(self, component_ref: str, profile: HRIComponentProfile) -> tuple[tuple[dict[str, _Refs], str], ...]:
        engine_id, _, name = component_ref.partition("/")
        return (self._by_engine, engine_id), (self._by_name, name), (self._by_type, profile.component_type)

    def refs_of(self, engine_id: str) -> Collection[str]:
        """Return the components of an engine."""
        return self._by_engine.get(engine_id, {}).keys()

    def search(self, condition: Condition) -> list[str]:
        """Return the components that satisfy a condition on `component_ref` and `component_type`."""
        of_ref = [each for each in condition.comparisons if each.property == "component_ref"]
        of_type = [each for each in condition.comparisons if each.property == "component_type"]
        typed = self._typed(of_type)
        groups = min((typed, *map(self._groups, of_ref)), key=_count)
        found = {ref for refs in groups for ref in refs if all(each.matches(ref) for each in of_ref)}
        if groups is not typed:
            found = {ref for ref in found if any(ref in refs for refs in typed)}
        return sorted(found, key=self._places.__getitem__)

    def _typed(self, comparisons: list[Comparison]) -> _Groups:
        """Return the components whose types satisfy all comparisons."""
        if not comparisons:
            return [self._places.keys()]
        return [refs.keys() for urn, refs in self._by_type.items() if all(each.matches(urn) for each in comparisons)]

    def _groups(self, comparison: Comparison) -> _Groups:
        """Return components among which are all whose reference satisfies a comparison."""
        if not comparison.pattern:
            return [(comparison.text,) if comparison.text in self._places else ()]
        if "/" in comparison.prefix:
            return [self.refs_of(engine_of(comparison.prefix))]
        everything: _Groups = [self._places.keys()]
        return min((everything, *map(self._containing, comparison.parts)), key=_count)

    def _containing(self, part: str) -> _Groups:
        """Return the components with a text in the engine's id or in the name: a reference has no other slash."""
        keyed = self._by_engine, self._by_name
        return [refs.keys() for groups in keyed for key, refs in groups.items() if part in key]


def _count(groups: _Groups) -> int:
    return sum(map(len, groups))
