"""The steps that a scene needs and those it leaves out, with the reason for each."""

from collections.abc import Iterator

from scenes.building.body_meshes import changed_elements
from scenes.checking.doubts import left_alone
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

GIVEN = "given, not used: "
"""Beginning of the reason of what is given though a run does without it."""


def needed_by(scene: Scene) -> dict[str, str]:
    """Steps of a run in their order, with the reason."""
    bodies, contacts, analysis = scene.bodies, scene.contacts, scene.analysis
    of_modes, every = analysis.kind == "cea", ", ".join(bodies)
    rotations = {n: b.rotation for n, b in bodies.items() if b.rotation is not None}
    damped = [name for name, body in bodies.items() if body.damping is not None]
    modal = [n for n, b in bodies.items() if b.damping is not None and b.damping.modal]
    damped += [name for name, contact in contacts.items() if contact.sliding is not None]
    convective = [name for name, each in rotations.items() if each.convective_stiffness]
    found = {
        "meshing": "; ".join(f"{n}: {_mesh(body)}" for n, body in bodies.items()),
        "search": "; ".join(f"{n}: {_search(c)}" for n, c in contacts.items()),
        "stiffness": f"K of {every}",
        "mass": f"M of {every}" if of_modes else "",
        "contact": "; ".join(f"K_n of {n}: {_stiffness(c)}" for n, c in contacts.items()),
        "friction": _of("K_f", [n for n, c in contacts.items() if c.mu], "mu is not zero"),
        "newton": _of("steady sliding", [n for n, c in contacts.items() if c.c_n], "has a law"),
        "load steps": f"of the loads: {analysis.load_steps}" if analysis.load_steps else "",
        "geometric stiffness": f"K_geo of {every}: asked for" if scene.stiffened_by_stress else "",
        "damping": _of("C", damped) if of_modes and scene.damped else "",
        "modal damping": _of("modes alone", modal) if of_modes else "",
        "gyroscopic": _of("Y", list(rotations)) if of_modes else "",
        "convective stiffness": _of("K", convective, "asked for"),
        "circulatory stiffness": _of(
            "K", [n for n, body in bodies.items() if body.circulates], "damping rotates with them"
        ),
    }
    if analysis.kind == "cea":
        kind = f"linear in lambda^2, {'unsymmetric' if scene.has_friction else 'symmetric'}"
        if scene.damped or scene.rotates:
            kind = "quadratic in lambda: velocities count"
        found["eigenvalues"] = f"to {analysis.max_frequency:g} Hz; {kind}"
    elif not scene.slides_steadily:
        found["solve"] = "displacement under the loads"
    for name, count in (("pictures", scene.output.pictures), ("paraview", scene.output.paraview)):
        if count:
            found[name] = f"of {count} modes" if of_modes else "asked for"
    return {name: reason for name, reason in found.items() if reason}


def _of(what: str, names: list[str], reason: str = "") -> str:
    """What is made for some bodies or contacts; nothing where there are none."""
    return f"{what} of {', '.join(names)}{f': {reason}' if reason else ''}" if names else ""


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
    return skipped | changed_elements(scene)


def _unused(scene: Scene) -> Iterator[tuple[str, str]]:
    """Fields that are given though the run does without them, with the reason."""
    analysis = scene.analysis
    if analysis.kind == "cea":
        if scene.loads and not scene.slides_steadily:
            yield "loads", "the stiffness of every contact is given, so that loads change no mode"
        if analysis.min_growth is not None and not (scene.damped or scene.rotates):
            yield "analysis.min_growth", "nothing damps or rotates, and every growth is sought"
    for name, contact in scene.contacts.items():
        if contact.mu != 0:
            continue
        if contact.sliding is None and contact.friction_direction_on_a is not None:
            yield f"contacts.{name}.friction_direction_on_a", "mu = 0"
        elif contact.sliding is not None and contact.sliding.speed is not None:
            reason = "mu = 0: no friction turns with the direction of sliding"
            yield f"contacts.{name}.sliding.speed", reason
    for other, backend in (("fe", "iga"), ("iga", "fe")):
        names = [
            name
            for name, body in scene.bodies.items()
            if body.backend == backend and getattr(body.mesh, other) is not None
        ]
        if names:
            yield f"bodies.*.mesh.{other}", f"{', '.join(names)}: on the backend {backend}"
