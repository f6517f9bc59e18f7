"""Scenes of supports in frames of their own, and what these bear on any number of ranks."""

import numpy as np
from blocks import alone, scene_body, two_blocks

from scenes import read_scene, run_scene

E, NU = 2.0, 0.3
INNER, OUTER, MOVED = 0.5, 1.0, 1e-3
GPTS = {"formulation": {"method": "gpts", "points": 3}}
MORTAR = {"formulation": {"method": "mortar"}}
LAW = {"c_n": 10.0, "m_n": 1.5}
CONTACTS = {
    "penalty": GPTS | {"form": "penalty"},
    "saddle": GPTS | {"form": "saddle"},
    "full pass": GPTS | {"form": "saddle", "full_pass": True},
    "tied": {"formulation": {"method": "segments"}, "P": float("inf")},
    "mortar": MORTAR,
    "mortar, full pass": MORTAR | {"full_pass": True},
    "mortar, tied": MORTAR | {"P": float("inf")},
    "bonded": {"formulation": {"method": "bonded"}},
    "lumped": {"formulation": GPTS["formulation"] | {"lumped": True}},
    "law": GPTS | LAW,
    "law, mortar": MORTAR | LAW,
    "law, full pass": GPTS | LAW | {"full_pass": True},
}
"""Contacts of every kind: their fields."""


def sector(backend, sides):
    """A quarter of a ring in plane strain whose outer rim is moved along the radius.

    Of its straight sides, start and end, a component each is held.
    """
    supports = [{"surface": "outer", "components": ["radial"], "value": MOVED}]
    supports += [
        {"surface": name, "components": [held]}
        for name, held in zip(("start", "end"), sides, strict=True)
    ]
    radii = {"inner_radius": INNER, "outer_radius": OUTER}
    shape = {"shape": "ring_sector", "start": 0.0, "end": 90.0, **radii}
    return alone(scene_body(backend, shape, [3, 6], 3, supports=supports), None)


def pressed(backend, contact, *, mu=0.3):
    """A block pressed by its ceiling, beside walls whose edges lie in the contact, on another."""
    data = two_blocks(backend, {}, mu=mu, held=True)
    wall = {"surface": "x_min", "components": ["normal"]}
    ceiling = {"surface": "z_max", "components": ["y", "z"], "value": [0.0, -1e-2]}
    data["bodies"]["upper"]["supports"] = [wall, ceiling]
    fields = data["contacts"]["interface"] | CONTACTS[contact]
    if "c_n" in fields:
        del fields["P"]
    if contact == "bonded":
        fields = {name: fields[name] for name in ("a", "b", "formulation")} | {"P": 3.0}
    elif mu == 0:
        fields = {n: v for n, v in fields.items() if n not in ("mu", "friction_direction_on_a")}
    data["contacts"]["interface"] = fields
    data["analysis"] = {"kind": "static", "samples": 5}
    return data


def borne(*contacts):
    """What supports bear, by backend and kind of contact; and of the sector."""
    found = {}
    for backend in ("fe", "iga"):
        scenes = {name: pressed(backend, name) for name in contacts}
        scenes["sector"] = sector(backend, ("normal", "circumferential"))
        for name, data in scenes.items():
            reactions = run_scene(read_scene(data)).reactions
            found[f"{backend} {name}"] = {
                body: np.round(force, 15).tolist() for body, force in reactions.items()
            }
    return found
