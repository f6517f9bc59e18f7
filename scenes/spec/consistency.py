"""What is wrong with a scene between its fields, each of which is right by itself."""

from collections.abc import Iterable, Iterator, Sequence

from cea.errors import InputError
from cea.suggestions import did_you_mean
from meshes.breaks import breaks_of, check_breaks
from meshes.edge_layers import check_edges, check_room
from meshes.mesh_file import MeshFile
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.spec.analysis import Analysis
from scenes.spec.body import BodySpec
from scenes.spec.contact_checks import contact_checks, fault_of, unknown_surface
from scenes.spec.limits import limit_checks
from scenes.spec.load import LoadSpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.spec.rotation_checks import rotation_checks
from scenes.spec.scene import SceneSpec
from scenes.spec.sizes import MAX_ELEMENTS, box_lengths, dofs_of


def cross_checks(scene: SceneSpec) -> Iterable[InputError]:
    """Faults between fields, each of which is right by itself."""
    yield from limit_checks(scene)
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


_THIN = 1e-12
"""Smallest range of a coordinate, relative to the coordinate."""

_CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}


def _mesh_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Meshes that do not suit the dimension of the shape."""
    directions = body.geometry.directions
    dim, names = len(directions), ", ".join(directions)
    yield from _file_checks(place, body)
    if body.geometry.shape in ("patches", "nurbs_file") and body.backend == "fe":
        yield InputError(f"{place}.backend", "fe", "'iga' for a geometry of patches")
    fe, iga = body.mesh.fe, body.mesh.iga
    if isinstance(body.geometry, VentilatedDisc):
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
    for backend, mesh in (("fe", fe), ("iga", iga)):
        if mesh is not None and mesh.elements is not None and len(mesh.elements) == dim:
            yield from _elements_checks(f"{place}.mesh.{backend}", body, mesh)


def _file_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Meshes beside that of a file, and degrees of a file that is none."""
    mesh = body.mesh
    if not isinstance(body.geometry, MeshFile):
        if mesh.degree is not None:
            allowed = "left out but of a mesh file: fe.degree or iga.degree says it"
            yield InputError(f"{place}.mesh.degree", mesh.degree, allowed)
        return
    if body.backend != "fe":
        yield InputError(f"{place}.backend", body.backend, "'fe' for a mesh file")
    for name in ("fe", "iga"):
        if getattr(mesh, name) is not None:
            allowed = "left out: cells are those of the file; mesh.degree may be given"
            yield InputError(f"{place}.mesh.{name}", getattr(mesh, name), allowed)


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
        yield InputError(
            f"{place}.mesh.fe.geometry_degree",
            fe.geometry_degree,
            f"1 to {MAX_CURVED} for shape = {shape!r}, whatever the degree of the elements",
        )


def _elements_checks(place: str, body: BodySpec, mesh: FeMesh | IgaMesh) -> Iterable[InputError]:
    """Elements that are too few for their shape, or too many for any machine."""
    elements = mesh.elements or ()
    if not all(1 <= count <= MAX_ELEMENTS for count in elements):
        yield InputError(f"{place}.elements", elements, f"1 to {MAX_ELEMENTS} along each direction")
    else:
        edges = mesh.edges if isinstance(mesh, FeMesh) else ()
        faults = list(fault_of(check_edges, body.geometry, edges, place)) if edges else []
        through = mesh.boundaries if isinstance(mesh, FeMesh) else mesh.through
        faults = faults or list(fault_of(check_breaks, body.geometry, elements, through, place))
        yield from faults
        if edges and not faults:
            breaks = breaks_of(body.geometry, elements, through)
            yield from fault_of(check_room, body.geometry, breaks, edges, place)


def _space_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Places, supports and springs that do not suit the dimension of the shape."""
    dim = len(body.geometry.directions)
    yield from fault_of(body.placement.check, dim, f"{place}.placement")
    for i, support in enumerate(body.supports):
        yield from fault_of(support.support().check, dim, f"{place}.supports.{i}")
    yield from rotation_checks(place, body)
    for i, spring in enumerate(body.springs):
        if len(spring.stiffness) != dim:
            allowed = f"{dim} values (N/m^3), one for each component"
            yield InputError(f"{place}.springs.{i}.stiffness", spring.stiffness, allowed)
    for name, (low, high) in zip(body.geometry.directions, body.geometry.extent, strict=True):
        if not high - low > _THIN * max(abs(low), abs(high)):
            allowed = "a range that is not lost in the rounding of its ends"
            yield InputError(f"{place}.geometry", f"{name} from {low} to {high}", allowed)


def _body_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    of_mesh = list(_mesh_checks(place, body))
    yield from of_mesh or size_checks(place, body)
    yield from _space_checks(place, body)
    of_file = isinstance(body.geometry, MeshFile)
    if not of_file and body.mesh == MeshSpec():
        yield InputError(f"{place}.mesh", None, "field required, but for a mesh file")
    elif not of_file and getattr(body.mesh, body.backend) is None:
        yield InputError(f"{place}.mesh.{body.backend}", None, f"needed for {body.backend!r}")
    for kind in ("supports", "springs"):
        for i, item in enumerate(getattr(body, kind)):
            yield from unknown_surface(
                f"{place}.{kind}.{i}.surface", item.surface, body.geometry.surfaces
            )


def size_checks(place: str, body: BodySpec) -> Iterator[InputError]:
    """Faults of the size of elements, against the length of their body.

    Sizes between are refused by the memory that their mesh would take.

    Parameters
    ----------
    place
        Path of the body.
    body
        The body, whose mesh suits its shape.
    """
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


_NEEDS = "left out where no contact has c_n: no state of steady sliding is sought"


def steady_checks(scene: SceneSpec) -> Iterable[InputError]:
    """Fields that mean nothing without a state of steady sliding."""
    if any(contact.c_n is not None for contact in scene.contacts.values()):
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
    """Fields of an analysis that need a state of steady sliding.

    Parameters
    ----------
    analysis
        The analysis.
    allowed
        What is allowed where there is none.
    """
    if analysis.load_steps is not None:
        yield InputError("analysis.load_steps", analysis.load_steps, allowed)
    if analysis.kind == "cea" and analysis.geometric_stiffness:
        yield InputError("analysis.geometric_stiffness", True, allowed)
