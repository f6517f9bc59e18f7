"""What is wrong with a scene between its fields, each of which is right by itself."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from cea.errors import InputError
from cea.suggestions import did_you_mean
from meshes.breaks import breaks_of, check_breaks
from meshes.edge_layers import check_edges, check_room
from meshes.mesh_file import MeshFile
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.spec.analysis import Analysis
from scenes.spec.body import BodySpec
from scenes.spec.contact_checks import contact_checks, fault_of, unknown_surface
from scenes.spec.load import LoadSpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.spec.scene import SceneSpec
from scenes.spec.sizes import MAX_ELEMENTS, box_lengths, dofs_of

LARGEST, SMALLEST = 1e30, 1e-30
"""Range of numbers, in the unit of each: lengths, stiffness and densities of any units fit, and
products of a few of them stay in the range of floating point numbers."""
MAX_ITEMS = 200
"""Bodies, contacts and loads of a scene, supports and springs of a body, of each so many."""
_LONGEST = 100
"""Characters of a name."""
_PARTING = set(".,[] ")
"""Characters that part the names of a path, which no name may hold."""
_SCALES = (
    "E", "rho", "P", "p", "c_n", "max_frequency", "size", "inner_radius", "outer_radius", "bore",
    "hub_radius", "reach", "speed", "frequencies",
)  # fmt: skip
"""Fields that set scales, and may not be next to nothing; coordinates and the like may."""
_LARGEST_OF = {"c_n": 1e90, "m_n": 20.0}
"""Fields of another range: c_n is a pressure over a small length to the power of m_n."""
_THIN = 1e-12
"""Smallest range of a coordinate, relative to the coordinate."""
_CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}
_NEEDS = "left out where no contact has c_n: no state of steady sliding is sought"


def cross_checks(scene: SceneSpec) -> Iterable[InputError]:
    """Faults between fields, each of which is right by itself."""
    yield from _limit_checks(scene)
    if not scene.bodies:
        yield InputError("bodies", {}, "at least one body")
    for name, body in scene.bodies.items():
        yield from _body_checks(f"bodies.{name}", body)
        if scene.analysis.kind == "cea" or body.rotates_in_equilibrium:
            yield from fault_of(body.material.density, f"bodies.{name}.material")
    known = sorted(f"{n}.{s}" for n, body in scene.bodies.items() for s in body.geometry.surfaces)
    yield from contact_checks(scene, known)
    for i, load in enumerate(scene.loads):
        yield from _load_checks(scene, f"loads.{i}", load, known)
    yield from steady_checks(scene)


def _limit_checks(scene: SceneSpec) -> Iterator[InputError]:
    """Names that no path holds, more items than anybody has, and extreme numbers."""
    yield from scene_name_checks(scene.name)
    counts = {name: len(getattr(scene, name)) for name in ("bodies", "contacts", "loads")}
    for name, body in scene.bodies.items():
        counts[f"bodies.{name}.supports"] = len(body.supports)
        counts[f"bodies.{name}.springs"] = len(body.springs)
    for place, count in counts.items():
        if count > MAX_ITEMS:
            yield InputError(place, f"{count} of them", f"at most {MAX_ITEMS}")
    names = [("bodies", name) for name in scene.bodies]
    names += [("contacts", name) for name in scene.contacts]
    for body_name, body in scene.bodies.items():
        names += [(f"bodies.{body_name}.geometry.faces", each) for each in body.geometry.surfaces]
    for place, name in names:
        if not (0 < len(name) <= _LONGEST and name.isprintable()) or set(name) & _PARTING:
            allowed = f"1 to {_LONGEST} printable characters, no dot, comma, bracket or blank"
            yield InputError(place, name, allowed)
    for place, number in _numbers(asdict(scene), ""):
        field = next(part for part in reversed(place.split(".")) if not part.isdecimal())
        largest = _LARGEST_OF.get(field, LARGEST)
        if abs(number) > largest and not (field in ("P", "p") and number == float("inf")):
            yield InputError(place, number, f"at most {largest:g}")
        elif field in _SCALES and 0 < abs(number) < SMALLEST:
            yield InputError(place, number, f"at least {SMALLEST:g}")


def scene_name_checks(name: str) -> Iterable[InputError]:
    """Faults of the name of a scene, which files and lines on a terminal bear."""
    if not (0 < len(name.strip()) <= len(name) <= _LONGEST and name.isprintable()):
        yield InputError("name", name, f"a name of 1 to {_LONGEST} printable characters")


def _numbers(value: Any, place: str) -> Iterator[tuple[str, float]]:
    """Numbers of nested tables and lists by their paths."""
    parts: Iterable[tuple[Any, Any]] = ()
    if isinstance(value, Mapping):
        parts = value.items()
    elif isinstance(value, list | tuple):
        parts = enumerate(value)
    elif isinstance(value, int | float):
        yield place, value
    for name, part in parts:
        yield from _numbers(part, f"{place}.{name}" if place else str(name))


def _load_checks(
    scene: SceneSpec, place: str, load: LoadSpec, known: Sequence[str]
) -> Iterable[InputError]:
    """Loads on what is not there, and forces of another dimension."""
    if load.surface is not None:
        yield from unknown_surface(f"{place}.surface", load.surface, known)
    elif load.body not in scene.bodies:
        allowed = f"one of {', '.join(scene.bodies)}{did_you_mean(load.body, scene.bodies)}"
        yield InputError(f"{place}.body", load.body, allowed)
    if load.on not in scene.bodies:
        return
    dim = len(scene.bodies[load.on].geometry.directions)
    for name, value in (("force", load.force), ("body_force", load.body_force)):
        if value is not None and len(value) != dim:
            yield InputError(f"{place}.{name}", value, f"{dim} components")


def _body_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Meshes, places, supports and springs that do not suit a shape."""
    of_mesh = list(_mesh_checks(place, body))
    yield from of_mesh or _size_checks(place, body)
    dim, of_file = len(body.geometry.directions), isinstance(body.geometry, MeshFile)
    yield from fault_of(body.placement.check, dim, f"{place}.placement")
    yield from fault_of(body.material.elasticity.check, dim, f"{place}.material")
    for i, support in enumerate(body.supports):
        yield from fault_of(support.support().check, dim, f"{place}.supports.{i}")
    if body.rotation is not None:
        from scenes.spec.rotation_checks import rotation_checks

        yield from rotation_checks(place, body, body.rotation)
    for i, spring in enumerate(body.springs):
        if len(spring.stiffness) != dim:
            allowed = f"{dim} values (N/m^3), one for each component"
            yield InputError(f"{place}.springs.{i}.stiffness", spring.stiffness, allowed)
    for name, (low, high) in zip(body.geometry.directions, body.geometry.extent, strict=True):
        if not high - low > _THIN * max(abs(low), abs(high)):
            allowed = "a range that is not lost in the rounding of its ends"
            yield InputError(f"{place}.geometry", f"{name} from {low} to {high}", allowed)
    if not of_file and body.mesh == MeshSpec():
        yield InputError(f"{place}.mesh", None, "field required, but for a mesh file")
    elif not of_file and getattr(body.mesh, body.backend) is None:
        yield InputError(f"{place}.mesh.{body.backend}", None, f"needed for {body.backend!r}")
    for kind in ("supports", "springs"):
        for i, item in enumerate(getattr(body, kind)):
            where = f"{place}.{kind}.{i}.surface"
            yield from unknown_surface(where, item.surface, body.geometry.surfaces)


def _mesh_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Meshes that do not suit their shape."""
    shape, mesh = body.geometry, body.mesh
    fe, iga, directions = mesh.fe, mesh.iga, shape.directions
    dim, names = len(directions), ", ".join(directions)
    if isinstance(shape, MeshFile):
        if body.backend != "fe":
            yield InputError(f"{place}.backend", body.backend, "'fe' for a mesh file")
        for name, given in (("fe", fe), ("iga", iga)):
            if given is not None:
                allowed = "left out: cells are those of the file; mesh.degree may be given"
                yield InputError(f"{place}.mesh.{name}", given, allowed)
    elif mesh.degree is not None:
        allowed = "left out but of a mesh file: fe.degree or iga.degree says it"
        yield InputError(f"{place}.mesh.degree", mesh.degree, allowed)
    if shape.shape in ("patches", "nurbs_file") and body.backend == "fe":
        yield InputError(f"{place}.backend", "fe", "'iga' for a geometry of patches")
    if isinstance(shape, VentilatedDisc):
        yield from _unstructured_checks(place, body)
        return
    if fe is not None and fe.cell not in _CELLS[dim]:
        yield InputError(f"{place}.mesh.fe.cell", fe.cell, " or ".join(_CELLS[dim]))
    numbers: dict[str, tuple[int, ...] | None] = {}
    if fe is not None:
        numbers |= {"fe.elements": fe.elements}
    if iga is not None:
        numbers |= {"iga.degree": iga.degree, "iga.elements": iga.elements}
        numbers |= {"iga.continuity": iga.continuity}
    for name, values in numbers.items():
        if values is not None and len(values) != dim:
            yield InputError(f"{place}.mesh.{name}", values, f"one number for each of {names}")
    for backend, one in (("fe", fe), ("iga", iga)):
        if one is not None and one.elements is not None and len(one.elements) == dim:
            yield from _elements_checks(f"{place}.mesh.{backend}", body, one)


def _unstructured_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Meshes other than unstructured tetrahedra, which alone fit some shapes."""
    shape, fe = body.geometry.shape, body.mesh.fe
    if body.backend == "iga":
        yield InputError(f"{place}.backend", "iga", f"'fe' for shape = {shape!r}")
    if fe is None:
        return
    if fe.cell != "tetrahedron":
        yield InputError(f"{place}.mesh.fe.cell", fe.cell, f"tetrahedron for shape = {shape!r}")
    elif fe.size is None:
        yield InputError(f"{place}.mesh.fe.elements", fe.elements, "left out, size given instead")
    if (fe.geometry_degree or fe.degree) > MAX_CURVED:
        allowed = f"1 to {MAX_CURVED} for shape = {shape!r}, whatever the degree of the elements"
        yield InputError(f"{place}.mesh.fe.geometry_degree", fe.geometry_degree, allowed)


def _elements_checks(place: str, body: BodySpec, mesh: FeMesh | IgaMesh) -> Iterable[InputError]:
    """Elements that are too few for their shape, or too many for any machine."""
    elements = mesh.elements or ()
    if not all(1 <= count <= MAX_ELEMENTS for count in elements):
        yield InputError(f"{place}.elements", elements, f"1 to {MAX_ELEMENTS} along each direction")
        return
    edges = mesh.edges if isinstance(mesh, FeMesh) else ()
    through = mesh.boundaries if isinstance(mesh, FeMesh) else mesh.through
    faults = list(fault_of(check_edges, body.geometry, edges, place)) if edges else []
    faults = faults or list(fault_of(check_breaks, body.geometry, elements, through, place))
    yield from faults
    if edges and not faults:
        breaks = breaks_of(body.geometry, elements, through)
        yield from fault_of(check_room, body.geometry, breaks, edges, place)


def _size_checks(place: str, body: BodySpec) -> Iterator[InputError]:
    """Sizes of elements that are none beside the length of their body."""
    fe = body.mesh.fe
    if body.backend != "fe" or fe is None or fe.size is None:
        return
    length = max(box_lengths(body.geometry))
    if not length / MAX_ELEMENTS <= fe.size <= length:
        allowed = (
            f"{length / MAX_ELEMENTS:.3g} to {length:.3g} (m), the length of the body; such a mesh "
            f"has about {dofs_of(body):.2g} unknowns"
        )
        yield InputError(f"{place}.mesh.fe.size", fe.size, allowed)


def steady_checks(scene: SceneSpec) -> Iterable[InputError]:
    """Fields that mean nothing without a state of steady sliding."""
    if scene.slides_steadily:
        return
    yield from needs_no_steady_state(scene.analysis, _NEEDS)
    if scene.analysis.kind == "static" and scene.output.pictures:
        allowed = "0 in a static analysis of which no contact has c_n"
        yield InputError("output.pictures", scene.output.pictures, allowed)
    for name, body in scene.bodies.items() if scene.analysis.kind == "cea" else ():
        for i, support in enumerate(body.supports):
            if support.value is not None:
                yield InputError(f"bodies.{name}.supports.{i}.value", support.value, _NEEDS)


def needs_no_steady_state(analysis: Analysis, allowed: str) -> Iterable[InputError]:
    """Fields of an analysis that need a state of steady sliding, and what is allowed without."""
    if analysis.load_steps is not None:
        yield InputError("analysis.load_steps", analysis.load_steps, allowed)
    if analysis.kind == "cea" and analysis.geometric_stiffness:
        yield InputError("analysis.geometric_stiffness", True, allowed)
