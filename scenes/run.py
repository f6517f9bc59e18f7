"""One scene from geometry to numbers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from cea.body import Body
from cea.contact.interface import Interface
from cea.eigen.krylov_schur import solve_modes
from cea.eigen.modes import Modes
from cea.eigen.static import solve_static
from cea.system.contact_stresses import SideStress, contact_stresses
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from scenes.build import build_bodies, build_interfaces, build_system
from scenes.read import Scene
from scenes.spec import ComplexEigenvalueAnalysis


@dataclass(frozen=True)
class SceneResult:
    """What running a scene gave.

    Parameters
    ----------
    scene
        The scene as run.
    system
        Its coupled matrices.
    interfaces
        Contact points by name of the contact.
    timer
        Seconds by stage.
    skipped
        What the scene did not need, with the reason.
    modes
        Modes of a complex eigenvalue analysis.
    displacement
        Displacement of a static analysis, PETSc vector.
    stresses
        Normal stresses of a static analysis: by contact, then side "a" or "b".
    """

    scene: Scene
    system: CoupledSystem
    interfaces: Mapping[str, Interface]
    timer: StageTimer
    skipped: Mapping[str, str]
    modes: Modes | None = None
    displacement: Any | None = None
    stresses: Mapping[str, Mapping[str, SideStress]] | None = None


def run_scene(
    scene: Scene,
    *,
    bodies: Mapping[str, Body] | None = None,
    leave_out: bool = True,
    listener: Callable[[str], None] | None = None,
) -> SceneResult:
    """Run a scene.

    Parameters
    ----------
    scene
        The scene.
    bodies
        Bodies already built for an equal ``bodies`` and ``loads`` section, to be used again with
        other contacts; their matrices are kept between runs.
    leave_out
        Whether friction is left out where mu = 0; False measures what that saves.
    listener
        Called with the name of each stage as it begins.
    """
    timer = StageTimer(listener)
    if bodies is None:
        bodies = build_bodies(scene, timer)
    interfaces = build_interfaces(scene, bodies, timer)
    system = build_system(scene, bodies, interfaces, timer, leave_out=leave_out)
    with timer("assembly"):
        pencil = system.pencil()
    parts: dict[str, Any]
    if isinstance(scene.analysis, ComplexEigenvalueAnalysis):
        modes = solve_modes(pencil, scene.analysis.max_frequency, timer=timer)
        parts = {"modes": modes}
    else:
        x = solve_static(pencil, system.load, timer)
        with timer("post-processing"):
            stresses = {
                name: contact_stresses(system, name, x, scene.analysis.samples)
                for name in scene.contacts
            }
        parts = {"displacement": x, "stresses": stresses}
    return SceneResult(scene, system, interfaces, timer, skipped_by(scene), **parts)


def skipped_by(scene: Scene) -> dict[str, str]:
    """What a scene does not need, with the reason; none of it is computed."""
    skipped = {
        "newton": "contact stiffness is known, no steady sliding state is sought",
        "damping": "no damping: the problem is linear in lambda^2",
        "gyroscopic": "no rotation of the frame",
    }
    if not any(contact.mu for contact in scene.contacts.values()):
        skipped["friction"] = "mu = 0: no slip operator, symmetric solver"
    if not scene.contacts:
        skipped["search"] = "no contacts"
    if scene.analysis.kind == "static":
        skipped["mass"] = "static analysis"
        skipped["eigenvalues"] = "static analysis"
        del skipped["damping"], skipped["gyroscopic"]
    elif not scene.loads:
        skipped["loads"] = "no loads"
    if not scene.output.pictures:
        skipped["pictures"] = "none asked for"
    if not scene.output.paraview:
        skipped["paraview"] = "no files for ParaView asked for"
    if all(body.backend == "iga" for body in scene.bodies.values()):
        skipped["gmsh"] = "no body is meshed"
    return skipped
