"""What a run leaves out, with the reason."""

from collections.abc import Iterator

from meshes.mesh_file import MeshFile
from scenes.checking.doubts import left_alone
from scenes.spec.reading import Scene

GIVEN = "given, not used: "
"""Beginning of the reason of what is given though a run does without it."""
CHANGED = "changed on reading: "
"""Beginning of what becomes of elements that meshes here do not have."""


def skipped_by(scene: Scene) -> dict[str, str]:
    """What a scene does not need, or gives without use, with the reason; none is computed."""
    rotations = [body.rotation for body in scene.bodies.values() if body.rotation is not None]
    of_modes = scene.analysis.kind == "cea"
    skipped = {field: f"{GIVEN}{reason}" for field, reason in _unused(scene)}
    if reason := left_alone(scene):
        skipped["doubts of units"] = reason
    if not scene.slides_steadily:
        skipped["newton"] = "contact stiffness is known, no steady sliding state is sought"
    if not scene.damped:
        linear = "" if rotations else ": the problem is linear in lambda^2"
        skipped["damping"] = f"no damping{linear}"
    if not rotations:
        skipped["gyroscopic"] = "no body rotates"
    elif not any(rotation.convective_stiffness for rotation in rotations):
        skipped["convective stiffness"] = "not asked for: of the order of rho Omega^2"
    if not scene.has_friction:
        skipped["friction"] = "mu = 0: no slip operator, symmetric solver"
    if of_modes and scene.slides_steadily and not scene.stiffened_by_stress:
        skipped["geometric stiffness"] = "not asked for: of the order of sigma / E"
    if not scene.contacts:
        skipped["search"] = "no contacts"
    if not of_modes:
        bodies = scene.bodies.values()
        used = {"damping": any(body.circulates for body in bodies), "gyroscopic": False}
        used["mass"] = any(body.rotates_in_equilibrium for body in bodies)
        skipped["eigenvalues"] = "static analysis"
        for name, acts in used.items():
            if skipped.pop(name, None) is None and not acts:
                skipped[name] = "static analysis"
    elif not scene.loads:
        skipped["loads"] = "no loads"
    if not scene.output.pictures:
        skipped["pictures"] = "none asked for"
    if not scene.output.paraview:
        skipped["paraview"] = "no files for ParaView asked for"
    meshes = [body.mesh.fe for body in scene.bodies.values() if body.backend == "fe"]
    if not any(mesh.size for mesh in meshes if mesh is not None):
        skipped["gmsh"] = "no body has an unstructured mesh"
    return skipped | _changed_elements(scene)


def _unused(scene: Scene) -> Iterator[tuple[str, str]]:
    """Fields that are given though the run does without them, with the reason."""
    analysis = scene.analysis
    if analysis.kind == "cea":
        if scene.loads and not scene.slides_steadily:
            yield "loads", "the stiffness of every contact is given, so that loads change no mode"
        if analysis.min_growth is not None and not (scene.damped or scene.rotates):
            yield "analysis.min_growth", "nothing damps or rotates, and every growth is sought"
    without_friction = [item for item in scene.contacts.items() if item[1].mu == 0]
    for name, contact in without_friction:
        if contact.sliding is None and contact.friction_direction_on_a is not None:
            yield f"contacts.{name}.friction_direction_on_a", "mu = 0"
        elif contact.sliding is not None and contact.sliding.speed is not None:
            reason = "mu = 0: no friction turns with the direction of sliding"
            yield f"contacts.{name}.sliding.speed", reason
    for other, backend in (("fe", "iga"), ("iga", "fe")):
        bodies = [item for item in scene.bodies.items() if item[1].backend == backend]
        names = [name for name, body in bodies if getattr(body.mesh, other) is not None]
        if names:
            yield f"bodies.*.mesh.{other}", f"{', '.join(names)}: on the backend {backend}"


def _changed_elements(scene: Scene) -> dict[str, str]:
    """What becomes of elements of mesh files that meshes here do not have, with the bodies."""
    files = {n: b.geometry for n, b in scene.bodies.items() if isinstance(b.geometry, MeshFile)}
    parts = {name: file.elements for name, file in files.items()}
    divided = [name for name, part in parts.items() if part.is_divided]
    filled = [name for name, part in parts.items() if part.incomplete and name not in divided]
    left_out = [f"{name}: {each}" for name, file in files.items() for each in file.content.told]
    told = {}
    if filled:
        of_files = f"{CHANGED}elements of {', '.join(filled)}"
        told["serendipity"] = f"{of_files} get the middles of faces and cells"
    if divided:
        of_files = f"{CHANGED}elements of several kinds of {', '.join(divided)}"
        told["mixed elements"] = f"{of_files} are divided into tetrahedra"
    if left_out:
        told["mesh files"] = f"{GIVEN}not taken from the file of {'; '.join(left_out)}"
    return told
