"""Stages that a run skips and inputs that it does not use, with the reasons."""

from collections.abc import Iterator

from meshes.mesh_file import MeshFile
from scenes.checking.warnings import left_alone
from scenes.spec.reading import Scene

GIVEN = "given, not used: "
"""Prefix of the reason for an input that the run does not use."""
CHANGED = "changed on reading: "
"""Prefix of the reason for elements of a mesh file that are converted to supported ones."""
_STATIC = "static analysis"

_Row = tuple[bool, str, str]
"""Whether an item is left out, its name, and the reason."""


def skipped_by(scene: Scene) -> dict[str, str]:
    """Return the stages that a scene does not need and its unused inputs, with the reasons."""
    rows = (*_unused(scene), *_not_needed(scene), *_changed_elements(scene))
    return {name: reason for left_out, name, reason in rows if left_out}


def _not_needed(scene: Scene) -> Iterator[_Row]:
    bodies, damped, rotates = list(scene.bodies.values()), scene.damped, scene.rotates
    static, without_units = scene.analysis.kind == "static", left_alone(scene)
    linear = "" if rotates else ": the problem is linear in lambda^2"
    convective = any(b.rotation and b.rotation.convective_stiffness for b in bodies)
    stressed = scene.slides_steadily and not scene.stiffened_by_stress
    unstructured = any(b.mesh.fe and b.mesh.fe.size for b in bodies if b.backend == "fe")
    yield bool(without_units), "doubts of units", without_units
    reason = "contact stiffness is given: no state of steady sliding is computed"
    yield not scene.slides_steadily, "newton", reason
    yield not static and not damped, "damping", f"no damping{linear}"
    yield not static and not rotates, "gyroscopic", "no body rotates"
    reason = "not requested: of the order of rho Omega^2"
    yield rotates and not convective, "convective stiffness", reason
    reason = "mu = 0: no slip operator"
    reason += "" if scene.has_turning_pressure else ", symmetric solver"
    yield not scene.has_friction, "friction", reason
    reason = "not requested: of the order of sigma / E"
    yield not static and stressed, "geometric stiffness", reason
    yield not scene.contacts, "search", "no contacts"
    yield static, "eigenvalues", _STATIC
    yield static and damped and not any(b.circulates for b in bodies), "damping", _STATIC
    yield static and rotates, "gyroscopic", _STATIC
    yield static and not any(b.rotates_in_equilibrium for b in bodies), "mass", _STATIC
    yield not static and not scene.loads, "loads", "no loads"
    yield not scene.output.pictures, "pictures", "none requested"
    yield not scene.output.paraview, "paraview", "no files for ParaView requested"
    yield not unstructured, "gmsh", "no body has an unstructured mesh"


def _unused(scene: Scene) -> Iterator[_Row]:
    """Yield the fields that are given but not used, with the reason."""
    analysis = scene.analysis
    if analysis.kind == "cea":
        reason = f"{GIVEN}the stiffness of every contact is given, so loads do not affect the modes"
        yield bool(scene.loads) and not scene.slides_steadily, "loads", reason
        reason = f"{GIVEN}without damping or rotation, the growth rate has no limit"
        given = analysis.min_growth is not None
        yield given and not (scene.damped or scene.rotates), "analysis.min_growth", reason
    for name, contact in scene.contacts.items():
        sliding, without = contact.sliding, contact.mu == 0
        directed = sliding is None and contact.friction_direction_on_a is not None
        field, reason = f"contacts.{name}.friction_direction_on_a", f"{GIVEN}mu = 0"
        yield without and directed, field, reason
        has_speed = sliding is not None and sliding.speed is not None
        reason += ": there is no friction that follows the sliding direction"
        yield without and has_speed, f"contacts.{name}.sliding.speed", reason
    for other, backend in (("fe", "iga"), ("iga", "fe")):
        bodies = [item for item in scene.bodies.items() if item[1].backend == backend]
        names = [name for name, body in bodies if getattr(body.mesh, other) is not None]
        reason = f"{GIVEN}{', '.join(names)} on the backend {backend}"
        yield bool(names), f"bodies.*.mesh.{other}", reason


def _changed_elements(scene: Scene) -> Iterator[_Row]:
    """Yield how unsupported elements of mesh files are converted, with the bodies."""
    shapes = {name: body.geometry for name, body in scene.bodies.items()}
    parts = {n: shape.elements for n, shape in shapes.items() if isinstance(shape, MeshFile)}
    divided = [name for name, part in parts.items() if part.is_divided]
    filled = [name for name, part in parts.items() if part.incomplete and name not in divided]
    reason = f"{CHANGED}midpoints of faces and cells are added to elements of {', '.join(filled)}"
    yield bool(filled), "serendipity", reason
    of_files = f"{CHANGED}elements of the mixed meshes of {', '.join(divided)}"
    yield bool(divided), "mixed elements", f"{of_files} are divided into tetrahedra"
