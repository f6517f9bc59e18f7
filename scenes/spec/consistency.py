"""What is wrong with a scene between its fields, each of which is right by itself."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from cea.contact.formulations import registered
from cea.errors import InputError, did_you_mean
from cea.expressions import Expression
from cea.supports.boundary import check_surface
from meshes.breaks import breaks_of
from meshes.edge_layers import check_room, run_along
from meshes.mesh_file import MeshFile
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.spec.body import BodySpec, FeMesh, IgaMesh, LoadSpec, MeshSpec
from scenes.spec.contact import ContactSpec, suits
from scenes.spec.plain import leaves
from scenes.spec.problems import fault_of

Scene = Any
""":class:`scenes.spec.reading.Scene`, whose module imports this one."""

LARGEST, SMALLEST = 1e30, 1e-30
"""Range of numbers, in the unit of each: lengths, stiffness and densities of any units fit, and
products of a few of them stay in the range of floating point numbers."""
MAX_ELEMENTS = 10**6
"""Elements along one direction."""
MAX_ITEMS = 200
"""Bodies, contacts and loads of a scene, supports and springs of a body, of each so many."""
_LONGEST = 100
"""Characters of a name."""
_PARTING = set(".,[] ")
"""Characters that part the names of a path, which no name may hold."""
_SCALES = (
    "E",
    "rho",
    "P",
    "p",
    "c_n",
    "max_frequency",
    "size",
    "inner_radius",
    "outer_radius",
    "bore",
    "hub_radius",
    "reach",
    "speed",
    "frequencies",
)
"""Fields that set scales, and may not be next to nothing; coordinates and the like may."""
_LARGEST_OF = {"c_n": 1e90, "m_n": 20.0}
"""Fields of another range: c_n is a pressure over a small length to the power of m_n."""
_THIN = 1e-12
"""Smallest range of a coordinate, relative to the coordinate."""
_CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}
_NEEDS = "left out where no contact has c_n: no state of steady sliding is sought"


def cross_checks(scene: Scene) -> Iterator[InputError]:
    """Faults between fields, each of which is right by itself."""
    yield from _limit_checks(scene)
    if not scene.bodies:
        yield InputError("bodies", {}, "at least one body")
    for name, body in scene.bodies.items():
        yield from _body_checks(f"bodies.{name}", body)
        if scene.analysis.kind == "cea" or body.rotates_in_equilibrium:
            yield from fault_of(body.material.density, f"bodies.{name}.material")
    known = sorted(f"{n}.{s}" for n, body in scene.bodies.items() for s in body.geometry.surfaces)
    yield from _contact_checks(scene, known)
    for i, load in enumerate(scene.loads):
        yield from _load_checks(scene, f"loads.{i}", load, known)
    if not scene.slides_steadily:
        yield from _steady_checks(scene)


def _limit_checks(scene: Scene) -> Iterator[InputError]:
    """Names that no path holds, more items than anybody has, and extreme numbers."""
    yield from scene_name_checks(scene.name)
    counts = {name: len(getattr(scene, name)) for name in ("bodies", "contacts", "loads")}
    names = [(kind, name) for kind in ("bodies", "contacts") for name in getattr(scene, kind)]
    for name, body in scene.bodies.items():
        counts[f"bodies.{name}.supports"] = len(body.supports)
        counts[f"bodies.{name}.springs"] = len(body.springs)
        names += [(f"bodies.{name}.geometry.faces", each) for each in body.geometry.surfaces]
    for place, count in counts.items():
        if count > MAX_ITEMS:
            yield InputError(place, f"{count} of them", f"at most {MAX_ITEMS}")
    for place, name in names:
        if not (0 < len(name) <= _LONGEST and name.isprintable()) or set(name) & _PARTING:
            allowed = f"1 to {_LONGEST} printable characters, no dot, comma, bracket or blank"
            yield InputError(place, name, allowed)
    numbers = [each for each in leaves(asdict(scene)) if isinstance(each[1], int | float)]
    for place, number in numbers:
        field = next(part for part in reversed(place.split(".")) if not part.isdecimal())
        largest = _LARGEST_OF.get(field, LARGEST)
        if abs(number) > largest and not (field in ("P", "p") and number == float("inf")):
            yield InputError(place, number, f"at most {largest:g}")
        elif field in _SCALES and 0 < abs(number) < SMALLEST:
            yield InputError(place, number, f"at least {SMALLEST:g}")


def scene_name_checks(name: str) -> Iterator[InputError]:
    """Faults of the name of a scene, which files and lines on a terminal bear."""
    if not (0 < len(name.strip()) <= len(name) <= _LONGEST and name.isprintable()):
        yield InputError("name", name, f"a name of 1 to {_LONGEST} printable characters")


def _other_lengths(
    place: str, lists: Mapping[str, Sequence[float] | None], dim: int, each: str
) -> Iterator[InputError]:
    """Lists that have another number of entries than space has dimensions."""
    for name, values in lists.items():
        if values is not None and len(values) != dim:
            yield InputError(f"{place}.{name}", values, f"{dim} numbers, one for each of {each}")


def _load_checks(
    scene: Scene, place: str, load: LoadSpec, known: Sequence[str]
) -> Iterator[InputError]:
    if load.surface is not None:
        yield from fault_of(check_surface, load.surface, known, f"{place}.surface")
    elif load.body not in scene.bodies:
        allowed = f"one of {', '.join(scene.bodies)}{did_you_mean(load.body, scene.bodies)}"
        yield InputError(f"{place}.body", load.body, allowed)
    if load.on in scene.bodies:
        dim = len(scene.bodies[load.on].geometry.directions)
        forces = {"force": load.force, "body_force": load.body_force}
        yield from _other_lengths(place, forces, dim, "the components")


def _body_checks(place: str, body: BodySpec) -> Iterator[InputError]:
    """Meshes, places, supports and springs that do not suit a shape."""
    shape, known = body.geometry, body.geometry.surfaces
    dim, mesh = len(shape.directions), body.mesh
    for name, (low, high) in zip(shape.directions, shape.extent, strict=True):
        if not high - low > _THIN * max(abs(low), abs(high)):
            allowed = "a range that is not lost in the rounding of its ends"
            yield InputError(f"{place}.geometry", f"{name} from {low} to {high}", allowed)
            break
    else:
        yield from _mesh_checks(f"{place}.mesh", body, dim)
    yield from fault_of(body.placement.check, dim, f"{place}.placement")
    yield from fault_of(body.material.elasticity.check, dim, f"{place}.material")
    for i, support in enumerate(body.supports):
        yield from fault_of(support.support().check, dim, f"{place}.supports.{i}")
        yield from fault_of(check_surface, support.surface, known, f"{place}.supports.{i}.surface")
    for i, spring in enumerate(body.springs):
        of_spring = {"stiffness": spring.stiffness}
        yield from _other_lengths(f"{place}.springs.{i}", of_spring, dim, "the components")
        yield from fault_of(check_surface, spring.surface, known, f"{place}.springs.{i}.surface")
    if body.rotation is not None:
        from scenes.spec.rotation_checks import rotation_checks

        yield from rotation_checks(place, body, body.rotation)
    suited = ("iga",) if shape.shape in ("patches", "nurbs_file") else ("fe", "iga")
    suited = ("fe",) if isinstance(shape, MeshFile | VentilatedDisc) else suited
    if body.backend not in suited:
        allowed = f"{suited[0]!r} for shape = {shape.shape!r}"
        yield InputError(f"{place}.backend", body.backend, allowed)
    if not isinstance(shape, MeshFile):
        if mesh == MeshSpec():
            yield InputError(f"{place}.mesh", None, "field required, but for a mesh file")
        elif getattr(mesh, body.backend) is None:
            yield InputError(f"{place}.mesh.{body.backend}", None, f"needed for {body.backend!r}")


def _mesh_checks(place: str, body: BodySpec, dim: int) -> Iterator[InputError]:
    """Cells, numbers and sizes of elements that do not suit a shape."""
    shape, fe, iga = body.geometry, body.mesh.fe, body.mesh.iga
    if isinstance(shape, MeshFile):
        for name, given in (("fe", fe), ("iga", iga)):
            if given is not None:
                allowed = "left out: cells are those of the file; mesh.degree may be given"
                yield InputError(f"{place}.{name}", given, allowed)
        return
    if body.mesh.degree is not None:
        allowed = "left out but of a mesh file: fe.degree or iga.degree says it"
        yield InputError(f"{place}.degree", body.mesh.degree, allowed)
    numbers: dict[str, tuple[int, ...] | None] = {}
    if fe is not None and isinstance(shape, VentilatedDisc):
        yield from _unstructured_checks(f"{place}.fe", fe)
    elif fe is not None:
        numbers["fe.elements"] = fe.elements
        if fe.cell not in _CELLS[dim]:
            yield InputError(f"{place}.fe.cell", fe.cell, " or ".join(_CELLS[dim]))
    if fe is not None and fe.size is not None and body.backend == "fe":
        length = max(body.lengths)
        if not length / MAX_ELEMENTS <= fe.size <= length:
            allowed = f"{length / MAX_ELEMENTS:.3g} to {length:.3g} (m), the length of the body"
            yield InputError(f"{place}.fe.size", fe.size, allowed)
    if iga is not None and not isinstance(shape, VentilatedDisc):
        numbers |= {"iga.degree": iga.degree, "iga.elements": iga.elements}
        numbers["iga.continuity"] = iga.continuity
    yield from _other_lengths(place, numbers, dim, ", ".join(shape.directions))
    for name, one in (("fe", fe), ("iga", iga)):
        if one is not None and len(numbers.get(f"{name}.elements") or ()) == dim:
            yield from _elements_checks(f"{place}.{name}", body, one)


def _unstructured_checks(place: str, fe: FeMesh) -> Iterator[InputError]:
    if fe.cell != "tetrahedron":
        yield InputError(f"{place}.cell", fe.cell, "tetrahedron for such a shape")
    elif fe.size is None:
        yield InputError(f"{place}.elements", fe.elements, "left out, size given instead")
    if (fe.geometry_degree or fe.degree) > MAX_CURVED:
        allowed = f"1 to {MAX_CURVED} for such a shape, whatever the degree of the elements"
        yield InputError(f"{place}.geometry_degree", fe.geometry_degree, allowed)


def _elements_checks(place: str, body: BodySpec, mesh: FeMesh | IgaMesh) -> Iterator[InputError]:
    """Numbers of elements, and edges of elements along a shape, that cannot be."""
    elements = mesh.elements or ()
    if not all(1 <= count <= MAX_ELEMENTS for count in elements):
        yield InputError(f"{place}.elements", elements, f"1 to {MAX_ELEMENTS} along each direction")
        return

    def check() -> None:
        edges = mesh.edges if isinstance(mesh, FeMesh) else ()
        through = mesh.boundaries if isinstance(mesh, FeMesh) else mesh.through
        if edges:
            run_along(body.geometry, edges)
        breaks = breaks_of(body.geometry, elements, through)
        if edges:
            check_room(body.geometry, breaks, edges)

    for fault in fault_of(check):
        value = tuple(elements) if fault.field == "elements" else fault.value
        yield InputError(f"{place}.{fault.field}", value, fault.allowed)


def _contact_checks(scene: Scene, known: Sequence[str]) -> Iterator[InputError]:
    """Faults of contacts; surfaces are known as "body.surface"."""
    seen: dict[frozenset[str], str] = {}
    for name, contact in scene.contacts.items():
        place = f"contacts.{name}"
        yield from _side_checks(scene, place, contact, known)
        pressure = contact.sliding.pressure if contact.sliding is not None else None
        if contact.sliding is not None and (pressure is None) == (contact.c_n is None):
            allowed = "either the contact pressure (N/m^2) or c_n, which makes it of the loads"
            yield InputError(f"{place}.sliding.pressure", pressure, allowed)
        yield from _dimension_checks(scene, place, contact)
        first = seen.setdefault(frozenset((contact.a, contact.b)), name)
        if first != name:
            allowed = f"other sides than contacts.{first}, which joins the same surfaces"
            yield InputError(f"{place}.a", f"{contact.a} on {contact.b}", allowed)


def _side_checks(
    scene: Scene, place: str, contact: ContactSpec, known: Sequence[str]
) -> Iterator[InputError]:
    """Sides that are not there, on one body, that cannot move, or have no such abscissae."""
    sides, rule = {"a": contact.a, "b": contact.b}, contact.formulation
    for side, where in sides.items():
        yield from fault_of(check_surface, where, known, f"{place}.{side}")
    if len({where.partition(".")[0] for where in sides.values()}) == 1:
        yield InputError(f"{place}.b", contact.b, f"another body than {contact.a}")
        return
    for side, where in sides.items():
        name, _, surface = where.partition(".")
        body = scene.bodies.get(name)
        if body is None:
            continue
        for i, support in enumerate(body.supports if where in known else ()):
            count = len(set(support.components))
            holds = count in (0, len(body.geometry.directions)) or "normal" in support.components
            if support.surface == surface and holds:
                allowed = f"a surface that may move: bodies.{name}.supports.{i} holds it"
                yield InputError(f"{place}.{side}", where, allowed)
        if (contact.full_pass or side == "a") and not suits(rule, body.backend):
            suited = [method for method, kind in registered().items() if suits(kind, body.backend)]
            allowed = f"one of {', '.join(suited)} where side {side} has backend {body.backend!r}"
            yield InputError(f"{place}.formulation.method", rule.method, allowed)


def _dimension_checks(scene: Scene, place: str, contact: ContactSpec) -> Iterator[InputError]:
    """Sides of different dimensions, and directions and fields of another one."""
    names = {side.split(".")[0] for side in (contact.a, contact.b)} & set(scene.bodies)
    dims = {len(scene.bodies[name].geometry.directions) for name in names}
    if len(dims) > 1:
        yield InputError(f"{place}.b", contact.b, f"a body of the same dimension as {contact.a}")
    for dim in dims if len(dims) == 1 else ():
        if (direction := contact.friction_direction_on_a) is not None:
            yield from fault_of(direction.check, dim, f"{place}.friction_direction_on_a")
        sliding = contact.sliding.fields if contact.sliding is not None else {}
        if dim == 2 and sliding.get("speed") is not None:
            allowed = "left out in the plane, where the direction of sliding cannot turn"
            yield InputError(f"{place}.sliding.speed", sliding["speed"], allowed)
        fields = {"p": contact.p, "mu": contact.mu}
        fields |= {f"sliding.{name}": value for name, value in sliding.items()}
        for name, value in fields.items():
            if isinstance(value, str):
                yield from fault_of(Expression(value).check, f"{place}.{name}", dim)


def _steady_checks(scene: Scene) -> Iterator[InputError]:
    """Fields that mean nothing without a state of steady sliding."""
    yield from needs_no_steady_state(scene.analysis, _NEEDS)
    if scene.analysis.kind == "static" and scene.output.pictures:
        allowed = "0 in a static analysis of which no contact has c_n"
        yield InputError("output.pictures", scene.output.pictures, allowed)
    for name, body in scene.bodies.items() if scene.analysis.kind == "cea" else ():
        for i, support in enumerate(body.supports):
            if support.value is not None:
                yield InputError(f"bodies.{name}.supports.{i}.value", support.value, _NEEDS)


def needs_no_steady_state(analysis: Any, allowed: str) -> Iterator[InputError]:
    """Fields of an analysis that need a state of steady sliding, and what is allowed without."""
    if analysis.load_steps is not None:
        yield InputError("analysis.load_steps", analysis.load_steps, allowed)
    if analysis.kind == "cea" and analysis.geometric_stiffness:
        yield InputError("analysis.geometric_stiffness", True, allowed)
