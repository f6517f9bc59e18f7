"""Bodies and coupled systems from scenes. A backend is imported only by a scene that uses it."""

from collections.abc import Mapping

from mpi4py import MPI

from cea.body import Body
from cea.boundary import Pressure
from cea.errors import InputError
from cea.formulations import Mortar
from cea.interface import Interface, default_reach, pair
from cea.system import ContactLaw, CoupledSystem, couple
from cea.timing import StageTimer
from comparisons.scene import BodySpec, ContactSpec, FeMesh, IgaMesh, Scene
from meshes.breaks import breaks_of


def build_bodies(scene: Scene, timer: StageTimer) -> dict[str, Body]:
    """Bodies of a scene by name."""
    loads = {name: [] for name in scene.bodies}  # type: dict[str, list[Pressure]]
    for load in scene.loads:
        body, surface = load.surface.split(".")
        loads[body].append(Pressure(surface, load.pressure))
    with timer("meshing"):
        return {
            name: build_body(name, spec, tuple(loads[name])) for name, spec in scene.bodies.items()
        }


def build_body(name: str, spec: BodySpec, pressures: tuple[Pressure, ...] = ()) -> Body:
    """One body of a scene on its backend."""
    if spec.backend == "fe" and spec.mesh.fe is not None:
        return _fe_body(name, spec, spec.mesh.fe, pressures)
    if spec.backend == "iga" and spec.mesh.iga is not None:
        return _iga_body(name, spec, spec.mesh.iga, pressures)
    raise InputError(f"bodies.{name}.mesh.{spec.backend}", None, f"needed for {spec.backend!r}")


def _fe_body(name: str, spec: BodySpec, mesh: FeMesh, pressures: tuple[Pressure, ...]) -> Body:
    from fe_cea import FEBody
    from meshes.gmsh_shapes import gmsh_mesh

    breaks = None
    if mesh.elements is not None:
        breaks = breaks_of(spec.geometry, mesh.elements, mesh.through)
    with gmsh_mesh(
        spec.geometry,
        mesh.cell,
        mesh.geometry_degree or mesh.degree,
        breaks=breaks,
        size=mesh.size,
        placement=spec.placement,
        comm=MPI.COMM_WORLD,
    ) as model:
        return FEBody.from_gmsh(
            name,
            model,
            degree=mesh.degree,
            material=spec.material,
            supports=[s.support() for s in spec.supports],
            springs=spec.springs,
            pressures=pressures,
        )


def _iga_body(name: str, spec: BodySpec, mesh: IgaMesh, pressures: tuple[Pressure, ...]) -> Body:
    from iga_cea import NurbsBody
    from meshes.nurbs_shapes import nurbs_shape

    breaks = breaks_of(spec.geometry, mesh.elements, mesh.through)
    shape = nurbs_shape(spec.geometry, breaks, spec.placement)
    return NurbsBody(
        name,
        shape.patches,
        shape.faces,
        degree=mesh.degree,
        continuity=mesh.continuity,
        material=spec.material,
        supports=[s.support() for s in spec.supports],
        springs=spec.springs,
        pressures=pressures,
    )


def build_interfaces(
    scene: Scene, bodies: Mapping[str, Body], timer: StageTimer
) -> dict[str, Interface]:
    """Contact points of a scene, located on their opposite sides."""
    interfaces = {}
    with timer("search"):
        for name, spec in scene.contacts.items():
            (body_a, a), (body_b, b) = spec.a.split("."), spec.b.split(".")
            side_a, side_b = bodies[body_a].surfaces[a], bodies[body_b].surfaces[b]
            reach = spec.reach or default_reach(side_a, side_b)
            interfaces[name] = pair(
                side_a,
                side_b,
                spec.formulation.points_on(side_a, side_b, reach),
                field=f"contacts.{name}",
                reach=reach,
                max_missed=spec.max_missed,
            )
    return interfaces


def contact_law(spec: ContactSpec, interface: Interface) -> ContactLaw:
    """Contact stiffness per area and friction: p as given, or P spread evenly over side a."""
    p = spec.p if spec.p is not None else _required(spec.P) / interface.a.area
    return ContactLaw(
        stiffness=p,
        mu=spec.mu,
        direction=spec.friction_direction_on_a,
        projected=isinstance(spec.formulation, Mortar),
    )


def _required(value: float | None) -> float:
    if value is None:
        raise InputError("P", None, "either P or p is given")
    return value


def build_system(
    scene: Scene,
    bodies: Mapping[str, Body],
    interfaces: Mapping[str, Interface],
    timer: StageTimer,
    *,
    leave_out: bool = True,
) -> CoupledSystem:
    """Coupled matrices of a scene: mass only for eigenvalues, loads only for statics."""
    contacts = {
        name: (
            spec.a.split(".")[0],
            spec.b.split(".")[0],
            interfaces[name],
            contact_law(spec, interfaces[name]),
        )
        for name, spec in scene.contacts.items()
    }
    static = scene.analysis.kind == "static"
    with timer("assembly"):
        return couple(bodies, contacts, with_mass=not static, with_load=static, leave_out=leave_out)
