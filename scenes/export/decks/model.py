"""The model of a deck: nodes, elements, sets, surfaces and materials, for any program."""

from collections.abc import Iterator, Mapping

from scenes.export.decks.bodies import DeckBody, material_name, set_name
from scenes.export.decks.lines import (
    comments,
    element_lines,
    face_lines,
    joined,
    keyword,
    node_lines,
    numbers,
    set_lines,
)
from scenes.export.decks.supports import transform_lines
from scenes.spec.reading import Scene


def model_text(scene: Scene, bodies: Mapping[str, DeckBody]) -> str:
    """Text of the model file, which the decks of all programs include."""
    heading = comments(
        [
            f"{scene.name}: bodies of the scene, their surfaces and materials.",
            *scene.description.splitlines(),
            "Sets of nodes and elements bear the names of the bodies; sets of nodes, and",
            "surfaces, the names of the bodies and their surfaces, as in pad-bottom.",
        ]
    )
    parts = [_body_lines(body) for body in bodies.values()]
    return joined([heading, *parts])


def _body_lines(body: DeckBody) -> list[str]:
    solid = keyword("SOLID SECTION", ELSET=body.name, MATERIAL=material_name(body.name))
    plane = ["1.,"] if body.mesh.dim == 2 else []  # the thickness
    return [
        keyword("NODE", NSET=body.name),
        *node_lines(body.first_node, body.mesh.points),
        keyword("ELEMENT", TYPE=body.element_type, ELSET=body.name),
        *element_lines(body.first_element, body.elements + body.first_node),
        *(line for name in body.mesh.surfaces for line in _surface_lines(body, name)),
        *transform_lines(body),
        *_material_lines(body),
        solid,
        *plane,
    ]


def _surface_lines(body: DeckBody, surface: str) -> Iterator[str]:
    name = set_name(f"{body.name}.{surface}")
    yield keyword("NSET", NSET=name)
    yield from set_lines(body.nodes_of(surface) + body.first_node)
    yield keyword("SURFACE", NAME=name, TYPE="ELEMENT")
    elements, faces = body.faces_of(surface)
    yield from face_lines(elements + body.first_element, faces)


def _material_lines(body: DeckBody) -> Iterator[str]:
    material = body.spec.material
    yield keyword("MATERIAL", NAME=material_name(body.name))
    yield keyword("ELASTIC")
    yield numbers([material.E, material.nu])
    if material.rho is not None:
        yield keyword("DENSITY")
        yield numbers([material.rho]) + ","
