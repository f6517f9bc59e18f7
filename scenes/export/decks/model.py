"""The model of a deck: nodes, elements, sets, surfaces and materials, for any program."""

from collections.abc import Iterator, Mapping

import numpy as np

from cea.elasticity import Axes, CylindricalAxes
from cea.material import IsotropicMaterial, Material, OrthotropicMaterial
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
    axes = body.spec.material.axes
    section = {"ELSET": body.name, "MATERIAL": material_name(body.name)}
    if axes is not None:
        section["ORIENTATION"] = f"{body.name}-axes"
    plane = ["1.,"] if body.mesh.dim == 2 else []  # the thickness
    return [
        keyword("NODE", NSET=body.name),
        *node_lines(body.first_node, body.mesh.points),
        keyword("ELEMENT", TYPE=body.element_type, ELSET=body.name),
        *element_lines(body.first_element, body.elements + body.first_node),
        *(line for name in body.mesh.surfaces for line in _surface_lines(body, name)),
        *transform_lines(body),
        *_axes_lines(body.name, axes),
        *_material_lines(body),
        keyword("SOLID SECTION", **section),
        *plane,
    ]


def _axes_lines(body: str, axes: Axes | CylindricalAxes | None) -> Iterator[str]:
    """Axes of the material: a point on axis 1 and one between 1 and 2, or two points of the axis."""
    if isinstance(axes, CylindricalAxes):
        yield keyword("ORIENTATION", NAME=f"{body}-axes", SYSTEM="CYLINDRICAL")
        end = np.add(axes.origin, axes.cylindrical_about)
        yield numbers([*axes.origin, *end.tolist()])
    elif axes is not None:
        yield keyword("ORIENTATION", NAME=f"{body}-axes", SYSTEM="RECTANGULAR")
        yield numbers([float(each) for each in (*axes.first, *axes.second)])


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
    yield from _elastic_lines(material)
    if material.rho is not None:
        yield keyword("DENSITY")
        yield numbers([material.rho]) + ","


def _elastic_lines(material: Material) -> Iterator[str]:
    """Constants in the axes of the material; shear stresses in the order 12, 13, 23."""
    if isinstance(material, IsotropicMaterial):
        yield keyword("ELASTIC")
        yield numbers([material.E, material.nu])
    elif isinstance(material, OrthotropicMaterial):
        s = np.linalg.inv(material.matrix)
        E1, E2, E3, G23, G13, G12 = 1 / np.diag(s)
        yield keyword("ELASTIC", TYPE="ENGINEERING CONSTANTS")
        yield numbers([E1, E2, E3, -s[0, 1] * E1, -s[0, 2] * E1, -s[1, 2] * E2, G12, G13])
        yield numbers([G23])
    else:
        order = [0, 1, 2, 5, 4, 3]
        c = material.matrix[np.ix_(order, order)]
        upper = [c[i, j] for j in range(6) for i in range(j + 1)]
        yield keyword("ELASTIC", TYPE="ANISOTROPIC")
        for start in range(0, len(upper), 8):
            yield numbers(upper[start : start + 8])
