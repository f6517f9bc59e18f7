"""The steps that a scene needs, with the reason for each; those it leaves out stand beside them."""

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
