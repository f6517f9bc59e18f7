"""Small scenes of two blocks, as dictionaries and assembled."""

from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_contacts, build_system
from scenes.spec.plain import checked
from scenes.spec.reading import Scene, read_scene

GPTS = {"method": "gpts", "points": 3}
FORMULATIONS = ["collocation", "weighted collocation", "grid", "gpts", "segments", "mortar"]
PLACEMENTS = ["axis-aligned", "rotated"]
"""Parameters of the fixtures `formulation` and `placement`."""
ROTATED = {"axis": [1.0, 2.0, -0.5], "angle": 37.0, "translation": [0.3, -0.2, 0.7]}


def scene_body(backend, geometry, elements, degree=2, **sections):
    """Body section of a scene: boxes, or quadrilaterals, of soft steel-like numbers."""
    dim = len(elements)
    cell = {2: "quadrilateral", 3: "hexahedron"}[dim]
    return {
        "backend": backend,
        "geometry": geometry,
        "material": {"E": 2.0, "nu": 0.3, "rho": 1.5},
        "mesh": {
            "fe": {"cell": cell, "degree": min(degree, 4), "elements": elements},
            "iga": {"degree": [degree] * dim, "elements": elements},
        },
    } | sections


def alone(body, max_frequency=1.0):
    """A scene of one body, "part"; static without a frequency."""
    analysis = {"kind": "cea", "max_frequency": max_frequency}
    if max_frequency is None:
        analysis = {"kind": "static"}
    return {"name": "alone", "bodies": {"part": body}, "analysis": analysis}


def block(backend, size, origin, elements, *, placement=None, **fields):
    """Body section of a scene: a block."""
    geometry = {"shape": "box", "size": size, "origin": origin}
    return scene_body(backend, geometry, elements, placement=placement or {}, **fields)


def contact(a, b, points, direction, *, mu=0.3, **fields):
    """Contact section of a scene: GPTS with friction."""
    formulation = {"method": "gpts", "points": points}
    friction = {"mu": mu, "friction_direction_on_a": direction}
    return {"a": a, "b": b, "formulation": formulation, **friction, **fields}


def rectangle(backend, size, elements, *, origin=(0.0, 0.0), degree=2, **fields):
    """Body section of a rectangle with the same elements on both backends, and other fields."""
    geometry = {"shape": "rectangle", "size": list(size), "origin": list(origin)}
    return scene_body(backend, geometry, elements, degree, **fields)


def two_blocks(backend, formulation, placement=None, *, mu=0.4, held=False, P=3.0, **fields):
    """Scene of a small block (a) on a larger one (b) whose meshes do not match.

    The contact has other fields; None stands for one that is left out.
    """
    direction = [1.0, 0.5, 0.0]
    if placement:
        from meshes.placement import Placement

        rotation = Placement(tuple(placement["axis"]), placement["angle"]).rotation
        direction = (rotation @ direction).tolist()
    upper = block(backend, [0.5, 0.6, 0.3], [0.2, 0.3, 0.4], [3, 2, 1])
    lower = block(backend, [1.0, 1.1, 0.4], [0.0, 0.0, 0.0], [4, 5, 1])
    for body, side in ((upper, "z_max"), (lower, "z_min")):
        body |= {"placement": placement or {}, "supports": [{"surface": side}] if held else []}
    return {
        "name": "two blocks",
        "bodies": {"upper": upper, "lower": lower},
        "contacts": {
            "interface": {
                "a": "upper.z_min",
                "b": "lower.z_max",
                "formulation": formulation,
                "P": P,
                "mu": mu,
                "friction_direction_on_a": {"vector": direction},
            }
            | fields
        },
        "analysis": {"kind": "cea", "max_frequency": 1.0, "growth_threshold": 10.0},
    }


def coarse(scene, degree=1):
    """A scene of two blocks with as few elements as do not match, on meshes of a degree."""
    for name, elements in (("upper", [2, 2, 1]), ("lower", [3, 3, 1])):
        mesh = scene["bodies"][name]["mesh"]
        mesh["fe"] |= {"elements": elements, "degree": degree}
        mesh["iga"]["elements"] = elements
    return scene


def assemble(data, *, together=True, **options):
    """Coupled system of a scene given as a dictionary.

    Where its sections need not fit ``together``, contacts may be there that scenes are refused for:
    the same one twice, or one between sides that are held.
    """
    scene, timer = read_scene(data) if together else checked(Scene, data), StageTimer()
    bodies = build_bodies(scene, timer)
    contacts = build_contacts(scene, bodies, timer)
    return build_system(scene, bodies, contacts, timer, **options)
