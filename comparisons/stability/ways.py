"""Ways to run a scene: on which backend, with which formulation, in which form."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Way:
    """Backend of every body and contact formulation."""

    backend: str
    name: str  # formulation and form in words; "no contact" without
    # fields of every contact: formulation, form, full_pass
    contact: Mapping[str, Any] = field(default_factory=dict)

    def of(self, scene: Mapping[str, Any]) -> dict[str, Any]:
        """A scene, as plain data, changed to this way; bonded contacts stay bonded."""
        data = deepcopy(dict(scene))
        for body in data["bodies"].values():
            body["backend"] = self.backend
        for contact in data.get("contacts", {}).values():
            if contact.get("formulation", {}).get("method") != "bonded":
                contact.update(deepcopy(dict(self.contact)))
        return data


Ways = tuple[Way, ...]
_GPTS = {"method": "gpts", "points": 3}
_FORMULATIONS: dict[str, dict[str, Any]] = {
    "node-to-surface": {"method": "node_to_surface"},
    "Greville": {"method": "greville"},
    "Botella": {"method": "botella"},
    "grid": {"method": "grid", "points": 5},
    "GPTS": _GPTS,
    "GPTS lumped": {**_GPTS, "lumped": True},
    "GPTS, full pass": _GPTS,
    "segments": {"method": "segments"},
    "mortar": {"method": "mortar"},
}
_NO_SADDLE = ("Botella", "grid", "GPTS lumped")
_OF_OTHERS = {"fe": ("Greville", "Botella"), "iga": ("node-to-surface",)}
WAYS: Ways = tuple(
    Way(
        backend,
        f"{name}, {form}",
        {"formulation": options, "full_pass": name.endswith("full pass"), "form": form},
    )
    for backend, of_others in _OF_OTHERS.items()
    for name, options in _FORMULATIONS.items()
    if name not in of_others
    for form in ("penalty", "saddle")
    if form == "penalty" or name not in _NO_SADDLE
)
"""Every formulation on both backends, in every form that it has."""


def chosen(ways: Ways, *names: str, backend: str = "", without: str = "\n") -> Ways:
    """Ways whose name begins with one of ``names`` and does not contain ``without``."""
    return tuple(
        way
        for way in ways
        if way.name.startswith(names or "") and without not in way.name
        if way.backend.startswith(backend)
    )


PENALTY = tuple(way for way in WAYS if way.contact["form"] == "penalty")
SADDLE = tuple(way for way in WAYS if way.contact["form"] == "saddle")
MORTAR = chosen(WAYS, "mortar")
_OPEN = {"formulation": {"method": "mortar"}, "full_pass": False}
OPEN = (Way("fe", "mortar, form left open", _OPEN), Way("iga", "mortar, form left open", _OPEN))
"""The form is left to the program."""
ALONE = (Way("fe", "no contact"), Way("iga", "no contact"))
"""Both backends, for scenes without contact or with fully specified contacts."""
QUICK = ("GPTS, penalty", "mortar, saddle")
"""Names of the ways of a quick run: one of the simplest, and one of the most accurate."""
FEW = chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar")
PAIR = chosen(WAYS, *QUICK)
UNIFORM = (
    *chosen(PENALTY, "GPTS,", "segments", "mortar"),
    *chosen(SADDLE, "GPTS,", "segments"),
    *OPEN,
)
"""Ways that transmit a uniform pressure on matching meshes and allow a contact law."""
