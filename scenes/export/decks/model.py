"""The model file of a deck: nodes, elements, sets, surfaces and materials."""

from collections.abc import Iterable, Iterator, Mapping
from io import StringIO
from itertools import batched

import numpy as np
from numpy.typing import ArrayLike

from cea.material import Axes, IsotropicMaterial, Material, OrthotropicMaterial
from scenes.export.decks.bodies import DeckBody, set_name
from scenes.spec.reading import Scene

_PER_LINE = 12
"""Entries of a set per line; the formats allow 16."""


def keyword(name: str, **parameters: object) -> str:
    """Return a keyword line; underscores in parameter names become spaces."""
    words = [f"{key.replace('_', ' ')}={value}" for key, value in parameters.items()]
    return ", ".join([f"*{name}", *words])


def comments(lines: Iterable[str]) -> list[str]:
    """Return comment lines; every line of a text becomes a comment."""
    return [f"** {part}".rstrip() for line in lines for part in line.splitlines()]


def numbers(*values: float) -> str:
    """Return a line of numbers of at most 20 characters each, the limit of CalculiX."""
    texts = [(repr(float(value)), value) for value in values]
    return ", ".join(text if len(text) <= 20 else f"{value:.13E}" for text, value in texts)


def table(rows: ArrayLike, form: str) -> list[str]:
    """Return a formatted line for each row."""
    text = StringIO()
    np.savetxt(text, np.asarray(rows), fmt=form)
    return text.getvalue().splitlines()


def model_lines(scene: Scene, bodies: Mapping[str, DeckBody]) -> Iterator[str]:
    """Yield the lines of the model file, which the deck includes."""
    yield from comments(
        [
            f"{scene.name}: bodies of the scene, their surfaces and materials.",
            *scene.description.splitlines(),
            "Node and element sets of bodies are named after the bodies; node sets and",
            "surfaces of their surfaces after both, e.g. pad-bottom.",
        ]
    )
    for body in bodies.values():
        yield from _body_lines(body)


def _body_lines(body: DeckBody) -> Iterator[str]:
    x, material = body.points, body.spec.material
    nodes = np.arange(body.first_node, body.first_node + len(x))
    yield keyword("NODE", NSET=body.name)
    yield from table(np.column_stack([nodes, x]), "%d" + ",%.13E" * 3)
    yield keyword("ELEMENT", TYPE=body.element_type, ELSET=body.name)
    count = np.arange(len(body.elements)) + body.first_element
    rows = np.column_stack([count, body.elements + body.first_node])
    yield from table(rows, ",".join(["%d"] * rows.shape[1]))
    for surface in body.mesh.surfaces:
        name = set_name(f"{body.name}.{surface}")
        yield keyword("NSET", NSET=name)
        members = (body.nodes_of(surface) + body.first_node).tolist()
        for some in batched(members, _PER_LINE):
            yield ",".join(map(str, some))
        yield keyword("SURFACE", NAME=name, TYPE="ELEMENT")
        elements, faces = body.faces[surface]
        yield from table(np.column_stack([elements + body.first_element, faces]), "%d,S%d")
    section = {"ELSET": body.name, "MATERIAL": f"{body.name}-material"}
    if material.axes is not None:
        section["ORIENTATION"] = f"{body.name}-axes"
        yield from _axes_lines(section["ORIENTATION"], material.axes)
    yield keyword("MATERIAL", NAME=section["MATERIAL"])
    yield from _elastic_lines(material)
    if material.rho is not None:
        yield from ("*DENSITY", f"{numbers(material.rho)},")
    yield keyword("SOLID SECTION", **section)


def _axes_lines(name: str, axes: Axes) -> Iterator[str]:
    """Yield the axes of a material: two vectors, or two points of the axis of a cylinder."""
    if axes.cylindrical_about is not None:
        end = np.add(axes.origin, axes.cylindrical_about)
        yield keyword("ORIENTATION", NAME=name, SYSTEM="CYLINDRICAL")
        yield numbers(*axes.origin, *end)
    elif axes.first and axes.second:
        yield keyword("ORIENTATION", NAME=name, SYSTEM="RECTANGULAR")
        yield numbers(*map(float, (*axes.first, *axes.second)))


def _elastic_lines(material: Material) -> Iterator[str]:
    """Yield the elastic constants in the material axes; shear is in the order 12, 13, 23."""
    if isinstance(material, IsotropicMaterial):
        yield from (keyword("ELASTIC"), numbers(material.E, material.nu))
    elif isinstance(material, OrthotropicMaterial):
        s = np.linalg.inv(material.elasticity.matrix)
        E1, E2, E3, G23, G13, G12 = 1 / np.diag(s)
        yield keyword("ELASTIC", TYPE="ENGINEERING CONSTANTS")
        yield numbers(E1, E2, E3, -s[0, 1] * E1, -s[0, 2] * E1, -s[1, 2] * E2, G12, G13)
        yield numbers(G23)
    else:
        order = [0, 1, 2, 5, 4, 3]
        c = material.elasticity.matrix[np.ix_(order, order)]
        upper = [c[i, j] for j in range(6) for i in range(j + 1)]
        yield keyword("ELASTIC", TYPE="ANISOTROPIC")
        for start in range(0, len(upper), 8):
            yield numbers(*upper[start : start + 8])


def boundary_lines(bodies: Mapping[str, DeckBody], **parameters: object) -> Iterator[str]:
    """Yield the supported components of all bodies; nothing if there are none."""
    held = [
        f"{set_name(f'{body.name}.{support.surface}')}, {first}, {last}"
        for body in bodies.values()
        for support in body.spec.supports
        for first, last in _ranges(support.components)
    ]
    if held or parameters:
        yield keyword("BOUNDARY", **parameters)
        yield from held


def _ranges(components: Iterable[str]) -> list[tuple[int, int]]:
    """Return ranges of supported component numbers; no names stand for all components."""
    found = sorted({"xyz".index(each) + 1 for each in components})
    return [(1, 3)] if len(found) in (0, 3) else [(each, each) for each in found]
