"""Ways to run a scene: on which backend, with which formulation, in which form."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any, Literal

Backend = Literal["fe", "iga"]

BONDED = "bonded"
"""Method that ways leave as it is: parts of one body stay parts of it."""


@dataclass(frozen=True)
class Way:
    """Backend and contact formulation.

    Parameters
    ----------
    backend
        Backend of every body.
    name
        Formulation and form in words, as a column of the heat map; "no contact" without.
    contact
        Fields of every contact: formulation, form, full_pass.
    """

    backend: Backend
    name: str
    contact: Mapping[str, Any] = field(default_factory=dict)

    def of(self, scene: Mapping[str, Any]) -> dict[str, Any]:
        """A scene, as plain data, run this way; bonded contacts stay bonded."""
        data = deepcopy(dict(scene))
        for body in data["bodies"].values():
            body["backend"] = self.backend
        for contact in data.get("contacts", {}).values():
            if contact.get("formulation", {}).get("method") != BONDED:
                contact.update(deepcopy(dict(self.contact)))
        return data


def _way(backend: Backend, name: str, form: str | None, **options: Any) -> Way:
    full = bool(options.pop("full_pass", False))
    contact = {"formulation": options, "full_pass": full} | ({"form": form} if form else {})
    words = [name, *(["full pass"] if full else []), form or "form left open"]
    return Way(backend, ", ".join(words), contact)


def _both_forms(backend: Backend, name: str, **options: Any) -> tuple[Way, ...]:
    return tuple(_way(backend, name, form, **options) for form in ("penalty", "saddle"))


def _ways(backend: Backend) -> tuple[Way, ...]:
    abscissae = {
        "fe": _both_forms("fe", "node-to-surface", method="node_to_surface"),
        "iga": (
            *_both_forms("iga", "Greville", method="greville"),
            _way("iga", "Botella", "penalty", method="botella"),
        ),
    }
    return (
        *abscissae[backend],
        _way(backend, "grid", "penalty", method="grid", points=5),
        *_both_forms(backend, "GPTS", method="gpts", points=3),
        _way(backend, "GPTS lumped", "penalty", method="gpts", points=3, lumped=True),
        *_both_forms(backend, "GPTS", method="gpts", points=3, full_pass=True),
        *_both_forms(backend, "segments", method="segments"),
        *_both_forms(backend, "mortar", method="mortar"),
    )


WAYS: tuple[Way, ...] = (*_ways("fe"), *_ways("iga"))
"""Every formulation on both backends."""

PENALTY = tuple(way for way in WAYS if way.contact["form"] == "penalty")
SADDLE = tuple(way for way in WAYS if way.contact["form"] == "saddle")
MORTAR = tuple(way for way in WAYS if way.name.startswith("mortar"))

OPEN = tuple(_way(backend, "mortar", None, method="mortar") for backend in ("fe", "iga"))
"""The form is left to the program."""

ALONE = (Way("fe", "no contact"), Way("iga", "no contact"))
"""Both backends, for scenes without contact or whose contacts say all."""

QUICK = ("GPTS, penalty", "mortar, saddle")
"""Names of the ways of a quick run: one each of the simplest and the most careful."""


def chosen(ways: tuple[Way, ...], *names: str, backend: Backend | None = None) -> tuple[Way, ...]:
    """Those of some ways whose name begins with one of the given, or of one backend."""
    return tuple(
        way
        for way in ways
        if (not names or way.name.startswith(names)) and backend in (None, way.backend)
    )


def without(ways: tuple[Way, ...], word: str) -> tuple[Way, ...]:
    """Those of some ways whose name does not hold a word."""
    return tuple(way for way in ways if word not in way.name)


FEW = chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar")
PAIR = chosen(WAYS, *QUICK)
UNIFORM = tuple(
    way
    for way in (*PENALTY, *SADDLE, *OPEN)
    if way.name.startswith(("GPTS,", "segments", "mortar")) and way.name != "mortar, saddle"
)
"""Those that pass a uniform pressure on meshes that match, and that a law can meet."""
