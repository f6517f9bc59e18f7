"""Ways to run a scene: on which backend, with which formulation, in which form."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any, Literal

Backend = Literal["fe", "iga"]


@dataclass(frozen=True)
class Way:
    """Backend of every body and contact formulation."""

    backend: Backend
    name: str  # formulation and form in words; "no contact" without
    # fields of every contact: formulation, form, full_pass
    contact: Mapping[str, Any] = field(default_factory=dict)

    def of(self, scene: Mapping[str, Any]) -> dict[str, Any]:
        """A scene, as plain data, run this way; bonded contacts stay bonded."""
        data = deepcopy(dict(scene))
        for body in data["bodies"].values():
            body["backend"] = self.backend
        for contact in data.get("contacts", {}).values():
            if contact.get("formulation", {}).get("method") != "bonded":
                contact.update(deepcopy(dict(self.contact)))
        return data


_BOTH = ("penalty", "saddle")
_PENALTY = ("penalty",)
_GPTS = {"method": "gpts", "points": 3}
_COLLOCATION: dict[Backend, list[tuple[str, dict[str, Any], tuple[str, ...]]]] = {
    "fe": [("node-to-surface", {"method": "node_to_surface"}, _BOTH)],
    "iga": [
        ("Greville", {"method": "greville"}, _BOTH),
        ("Botella", {"method": "botella"}, _PENALTY),
    ],
}


def _ways(backend: Backend) -> list[Way]:
    """Every formulation in every form that it has."""
    formulations = [
        *_COLLOCATION[backend],
        ("grid", {"method": "grid", "points": 5}, _PENALTY),
        ("GPTS", _GPTS, _BOTH),
        ("GPTS lumped", {**_GPTS, "lumped": True}, _PENALTY),
        ("GPTS, full pass", _GPTS, _BOTH),
        ("segments", {"method": "segments"}, _BOTH),
        ("mortar", {"method": "mortar"}, _BOTH),
    ]
    return [
        Way(
            backend,
            f"{name}, {form}",
            {"formulation": options, "full_pass": name.endswith("full pass"), "form": form},
        )
        for name, options, forms in formulations
        for form in forms
    ]


Ways = tuple[Way, ...]
WAYS: Ways = (*_ways("fe"), *_ways("iga"))
"""Every formulation on both backends."""
PENALTY = tuple(way for way in WAYS if way.contact["form"] == "penalty")
SADDLE = tuple(way for way in WAYS if way.contact["form"] == "saddle")
MORTAR = tuple(way for way in WAYS if way.name.startswith("mortar"))
_OPEN = {"formulation": {"method": "mortar"}, "full_pass": False}
OPEN = (Way("fe", "mortar, form left open", _OPEN), Way("iga", "mortar, form left open", _OPEN))
"""The form is left to the program."""
ALONE = (Way("fe", "no contact"), Way("iga", "no contact"))
"""Both backends, for scenes without contact or whose contacts say all."""
QUICK = ("GPTS, penalty", "mortar, saddle")
"""Names of the ways of a quick run: one each of the simplest and the most careful."""


def chosen(ways: Ways, *names: str, backend: Backend | None = None) -> Ways:
    """Those of some ways whose name begins with one of the given, or of one backend."""
    return tuple(
        way
        for way in ways
        if (not names or way.name.startswith(names)) and backend in (None, way.backend)
    )


def without(ways: Ways, word: str) -> Ways:
    """Those of some ways whose name does not hold a word."""
    return tuple(way for way in ways if word not in way.name)


FEW = chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar")
PAIR = chosen(WAYS, *QUICK)
UNIFORM = (
    *chosen(PENALTY, "GPTS,", "segments", "mortar"),
    *chosen(SADDLE, "GPTS,", "segments"),
    *OPEN,
)
"""Those that pass a uniform pressure on meshes that match, and that a law can meet."""
