"""What a run leaves out, with the reason."""

from collections.abc import Iterator

from meshes.mesh_file import MeshFile
from scenes.checking.warnings import left_alone
from scenes.spec.reading import Scene

GIVEN = "given, not used: "
"""Beginning of the reason of what is given though a run does without it."""
CHANGED = "changed on reading: "
"""Beginning of what becomes of elements that meshes here do not have."""
_STATIC = "static analysis"

_Row = tuple[bool, str, str]
"""Whether something is left out, what, and why."""


def skipped_by(scene: Scene) -> dict[str, str]:
    """What a scene does not need, or gives without use, with the reason; none is computed."""
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
    reason = "contact stiffness is known, no steady sliding state is sought"
    yield not scene.slides_steadily, "newton", reason
    yield not static and not damped, "damping", f"no damping{linear}"
    yield not static and not rotates, "gyroscopic", "no body rotates"
    reason = "not asked for: of the order of rho Omega^2"
    yield rotates and not convective, "convective stiffness", reason
    yield not scene.has_friction, "friction", "mu = 0: no slip operator, symmetric solver"
    reason = "not asked for: of the order of sigma / E"
    yield not static and stressed, "geometric stiffness", reason
    yield not scene.contacts, "search", "no contacts"
    yield static, "eigenvalues", _STATIC
    yield static and damped and not any(b.circulates for b in bodies), "damping", _STATIC
    yield static and rotates, "gyroscopic", _STATIC
    yield static and not any(b.rotates_in_equilibrium for b in bodies), "mass", _STATIC
    yield not static and not scene.loads, "loads", "no loads"
    yield not scene.output.pictures, "pictures", "none asked for"
    yield not scene.output.paraview, "paraview", "no files for ParaView asked for"
    yield not unstructured, "gmsh", "no body has an unstructured mesh"


def _unused(scene: Scene) -> Iterator[_Row]:
    """Fields that are given though the run does without them, with the reason."""
    analysis = scene.analysis
    if analysis.kind == "cea":
        reason = f"{GIVEN}the stiffness of every contact is given, so that loads change no mode"
        yield bool(scene.loads) and not scene.slides_steadily, "loads", reason
        reason = f"{GIVEN}nothing damps or rotates, and every growth is sought"
        given = analysis.min_growth is not None
        yield given and not (scene.damped or scene.rotates), "analysis.min_growth", reason
    for name, contact in scene.contacts.items():
        sliding, without = contact.sliding, contact.mu == 0
        directed = sliding is None and contact.friction_direction_on_a is not None
        field, reason = f"contacts.{name}.friction_direction_on_a", f"{GIVEN}mu = 0"
        yield without and directed, field, reason
        has_speed = sliding is not None and sliding.speed is not None
        reason += ": no friction turns with the direction of sliding"
        yield without and has_speed, f"contacts.{name}.sliding.speed", reason
    for other, backend in (("fe", "iga"), ("iga", "fe")):
        bodies = [item for item in scene.bodies.items() if item[1].backend == backend]
        names = [name for name, body in bodies if getattr(body.mesh, other) is not None]
        reason = f"{GIVEN}{', '.join(names)}: on the backend {backend}"
        yield bool(names), f"bodies.*.mesh.{other}", reason


def _changed_elements(scene: Scene) -> Iterator[_Row]:
    """What becomes of elements of mesh files that meshes here do not have, with the bodies."""
    files = {n: b.geometry for n, b in scene.bodies.items() if isinstance(b.geometry, MeshFile)}
    parts = {name: file.elements for name, file in files.items()}
    divided = [name for name, part in parts.items() if part.is_divided]
    filled = [name for name, part in parts.items() if part.incomplete and name not in divided]
    left_out = [f"{name}: {each}" for name, file in files.items() for each in file.content.told]
    reason = f"{CHANGED}elements of {', '.join(filled)} get the middles of faces and cells"
    yield bool(filled), "serendipity", reason
    of_files = f"{CHANGED}elements of several kinds of {', '.join(divided)}"
    yield bool(divided), "mixed elements", f"{of_files} are divided into tetrahedra"
    reason = f"{GIVEN}not taken from the file of {'; '.join(left_out)}"
    yield bool(left_out), "mesh files", reason
