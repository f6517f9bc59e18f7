"""Input of a scene that its run has no use for: told among what the run skipped, never ignored."""

from collections.abc import Iterator

from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

GIVEN = "given, not used: "
"""Beginning of the reason of each."""


def unused_input(scene: Scene) -> dict[str, str]:
    """Fields that are given though the run does without them, with the reason.

    Parameters
    ----------
    scene
        The scene.
    """
    return {field: f"{GIVEN}{reason}" for field, reason in _unused(scene)}


def _unused(scene: Scene) -> Iterator[tuple[str, str]]:
    """Fields and reasons."""
    analysis = scene.analysis
    if isinstance(analysis, ComplexEigenvalueAnalysis):
        if scene.loads and not scene.slides_steadily:
            yield "loads", "the stiffness of every contact is given, so that loads change no mode"
        if analysis.min_growth is not None and not (scene.damped or scene.rotates):
            yield "analysis.min_growth", "nothing damps or rotates, and every growth is sought"
    for name, contact in scene.contacts.items():
        for field, reason in _of_contact(contact):
            yield f"contacts.{name}.{field}", reason
    yield from _other_meshes(scene)


def _of_contact(contact: ContactSpec) -> Iterator[tuple[str, str]]:
    """Fields of a contact without friction."""
    if contact.mu != 0:
        return
    if contact.sliding is None:
        if contact.friction_direction_on_a is not None:
            yield "friction_direction_on_a", "mu = 0"
    elif contact.sliding.speed is not None:
        yield "sliding.speed", "mu = 0: no friction turns with the direction of sliding"


def _other_meshes(scene: Scene) -> Iterator[tuple[str, str]]:
    """Meshes for the backend that a body is not on, of all bodies together."""
    for other, backend in (("fe", "iga"), ("iga", "fe")):
        names = [
            name
            for name, body in scene.bodies.items()
            if body.backend == backend and getattr(body.mesh, other) is not None
        ]
        if names:
            yield f"bodies.*.mesh.{other}", f"{', '.join(names)}: on the backend {backend}"
