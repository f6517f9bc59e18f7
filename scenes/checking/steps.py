"""The steps that a scene needs and those it leaves out, with the reason for each."""

from scenes.building.body_meshes import changed_elements
from scenes.checking.doubts import left_alone
from scenes.checking.unused import unused_input
from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene


def needed_by(scene: Scene) -> dict[str, str]:
    """Steps of a run in their order, with the reason."""
    bodies, contacts = scene.bodies, scene.contacts
    steps = {"meshing": "; ".join(f"{n}: {_mesh(body)}" for n, body in bodies.items())}
    if contacts:
        steps["search"] = "; ".join(f"{n}: {_search(c)}" for n, c in contacts.items())
    steps["stiffness"] = f"K of {', '.join(bodies)}"
    if scene.analysis.kind == "cea":
        steps["mass"] = f"M of {', '.join(bodies)}"
    if contacts:
        steps["contact"] = "K_n of " + "; ".join(
            f"{n}: {_stiffness(c)}" for n, c in contacts.items()
        )
    if rubbing := [name for name, contact in contacts.items() if contact.mu]:
        steps["friction"] = f"K_f of {', '.join(rubbing)}: mu is not zero, K becomes unsymmetric"
    if scene.slides_steadily:
        laws = [name for name, contact in contacts.items() if contact.c_n is not None]
        steps["newton"] = (
            f"steady sliding under the loads: {', '.join(laws)} has a law of its closure"
        )
        if scene.analysis.load_steps is not None:
            steps["load steps"] = f"of the loads: {scene.analysis.load_steps}"
        if scene.stiffened_by_stress:
            steps["geometric stiffness"] = f"K_geo of {', '.join(bodies)}: asked for"
    if scene.analysis.kind == "cea":
        steps |= _of_velocities(scene)
    steps |= _of_rotation(scene)
    steps |= _solve(scene)
    for name, count in (("pictures", scene.output.pictures), ("paraview", scene.output.paraview)):
        if count:
            steps[name] = f"of {count} modes" if scene.analysis.kind == "cea" else "asked for"
    return steps


def _mesh(body: BodySpec) -> str:
    """How a body is divided, in words."""
    fe, iga = body.mesh.fe, body.mesh.iga
    if body.backend == "fe" and fe is not None:
        how = f"size {fe.size:g} m by gmsh" if fe.size is not None else _times(fe.elements or ())
        return f"{fe.cell} elements of degree {fe.degree}, {how}"
    if iga is None:
        return f"as its {body.geometry.shape} has it"
    return f"NURBS of degree {_times(iga.degree)}, {_times(iga.elements)} knot spans"


def _times(numbers: tuple[int, ...]) -> str:
    return " x ".join(map(str, numbers))


def _search(contact: ContactSpec) -> str:
    """Which points are looked for where."""
    passes = ", both passes" if contact.full_pass else ""
    return f"{contact.formulation.label} of {contact.a} on {contact.b}{passes}"


def _stiffness(contact: ContactSpec) -> str:
    """What makes the stiffness of a contact."""
    if contact.c_n is not None:
        return "p = m_n c_n (u_n - g_n)_+^(m_n - 1) of steady sliding"
    form = contact.form or "penalty, or saddle where that would cost more than six digits"
    return f"{f'P = {contact.P:g}' if contact.P is not None else f'p = {contact.p}'}, {form}"


def _of_velocities(scene: Scene) -> dict[str, str]:
    """What acts on velocities."""
    steps = {}
    damped = [name for name, body in scene.bodies.items() if body.damping is not None]
    damped += [name for name, contact in scene.contacts.items() if contact.sliding is not None]
    if scene.damped:
        steps["damping"] = f"C of {', '.join(damped)}"
    modal = [n for n, b in scene.bodies.items() if b.damping is not None and b.damping.modal]
    if modal:
        steps["modal damping"] = f"modes of {', '.join(modal)} alone, found first"
    rotations = {n: b.rotation for n, b in scene.bodies.items() if b.rotation is not None}
    if rotations:
        steps["gyroscopic"] = f"Y of {', '.join(rotations)}"
    return steps


def _of_rotation(scene: Scene) -> dict[str, str]:
    """What rotation makes of displacements that are at rest in space."""
    steps, rotations = {}, {n: b.rotation for n, b in scene.bodies.items() if b.rotation}
    if convective := [n for n, r in rotations.items() if r.convective_stiffness]:
        steps["convective stiffness"] = f"of {', '.join(convective)}: asked for"
    if carried := [n for n, body in scene.bodies.items() if body.circulates]:
        steps["circulatory stiffness"] = f"of {', '.join(carried)}: damping rotates with them"
    return steps


def _solve(scene: Scene) -> dict[str, str]:
    """What is solved."""
    analysis = scene.analysis
    if not isinstance(analysis, ComplexEigenvalueAnalysis):
        return {} if scene.slides_steadily else {"solve": "displacement under the loads"}
    symmetric = not any(contact.mu for contact in scene.contacts.values())
    if scene.damped or scene.rotates:
        kind = "quadratic in lambda: velocities count; at real shifts"
    else:
        kind = f"linear in lambda^2, {'symmetric' if symmetric else 'unsymmetric by friction'}"
    return {"eigenvalues": f"to {analysis.max_frequency:g} Hz; {kind}"}


def skipped_by(scene: Scene) -> dict[str, str]:
    """What a scene does not need, or gives without use, with the reason; none is computed."""
    rotations = [body.rotation for body in scene.bodies.values() if body.rotation is not None]
    skipped = unused_input(scene)
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
    if not any(contact.mu for contact in scene.contacts.values()):
        skipped["friction"] = "mu = 0: no slip operator, symmetric solver"
    of_modes = scene.analysis.kind == "cea"
    if of_modes and scene.slides_steadily and not scene.stiffened_by_stress:
        skipped["geometric stiffness"] = "not asked for: of the order of sigma / E"
    if not scene.contacts:
        skipped["search"] = "no contacts"
    if scene.analysis.kind == "static":
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
    return skipped | changed_elements(scene)
