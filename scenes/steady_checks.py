"""What a scene is refused for that asks for steady sliding where there is none."""

from collections.abc import Iterable

from cea.errors import InputError
from scenes.spec.analysis import Analysis
from scenes.spec.scene import SceneSpec

_NEEDS = "left out where no contact has c_n: no state of steady sliding is sought"


def steady_checks(scene: SceneSpec) -> Iterable[InputError]:
    """Fields that mean nothing without a state of steady sliding."""
    if any(contact.c_n is not None for contact in scene.contacts.values()):
        return
    yield from needs_no_steady_state(scene.analysis, _NEEDS)
    if scene.analysis.kind == "static" and scene.output.pictures:
        allowed = "0 in a static analysis of which no contact has c_n"
        yield InputError("output.pictures", scene.output.pictures, allowed)
    for name, body in scene.bodies.items() if scene.analysis.kind == "cea" else ():
        for i, support in enumerate(body.supports):
            if support.value is not None:
                yield InputError(f"bodies.{name}.supports.{i}.value", support.value, _NEEDS)


def needs_no_steady_state(analysis: Analysis, allowed: str) -> Iterable[InputError]:
    """Fields of an analysis that need a state of steady sliding.

    Parameters
    ----------
    analysis
        The analysis.
    allowed
        What is allowed where there is none.
    """
    if analysis.load_steps is not None:
        yield InputError("analysis.load_steps", analysis.load_steps, allowed)
    if analysis.kind == "cea" and analysis.geometric_stiffness:
        yield InputError("analysis.geometric_stiffness", True, allowed)
