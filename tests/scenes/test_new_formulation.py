"""A formulation defined outside the package is one class: scenes name it on both backends."""

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import pytest
from blocks import coarse, two_blocks

from cea.contact import formulations
from cea.contact.formulations import Formulation, register, registered
from cea.errors import InputError
from scenes import run_scene
from scenes.spec.plain import plain_data
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene


@dataclass(frozen=True)
class Midpoints(Formulation):
    """Contact at the middle of each cell of side a."""

    name: ClassVar[str] = "midpoints"

    softness: float = 1.0
    method: Literal["midpoints"] = "midpoints"

    def points_on(self, a, b, reach):
        """Points and weights on side a."""
        points = a.gauss_points(1)
        return replace(points, weight=points.weight / self.softness)


@pytest.fixture(autouse=True)
def _registered(monkeypatch):
    monkeypatch.setattr(formulations, "_REGISTER", dict(formulations._REGISTER))
    register(Midpoints)


def test_a_scene_names_it_and_both_backends_run_it(backend):
    def eigenvalues(formulation):
        data = coarse(two_blocks(backend, formulation, held=True))
        return run_scene(read_scene(data).change("analysis.max_frequency", 0.7)).modes.eigenvalues

    found = eigenvalues({"method": "midpoints"})
    assert found == pytest.approx(eigenvalues({"method": "gpts", "points": 1}), rel=1e-9)
    others = eigenvalues({"method": "gpts", "points": 3})
    assert found[:5] != pytest.approx(others[:5], rel=1e-6)


def test_its_fields_are_read_checked_and_written():
    scene = read_scene(two_blocks("iga", {"method": "midpoints", "softness": 2.0}))
    assert scene.contacts["interface"].formulation == Midpoints(2.0)
    assert read_scene(plain_data(scene)) == scene
    with pytest.raises(SceneError, match=r"formulation\.hardness = 1: no such field"):
        read_scene(two_blocks("iga", {"method": "midpoints", "hardness": 1}))


def test_a_method_that_is_not_registered_is_refused_with_those_that_are():
    with pytest.raises(SceneError, match="midpoints") as caught:
        read_scene(two_blocks("iga", {"method": "corners"}))
    assert all(method in str(caught.value) for method in registered())
    del formulations._REGISTER["midpoints"]
    with pytest.raises(SceneError, match=r"method = 'midpoints': one of (?!.*midpoints)"):
        read_scene(two_blocks("iga", {"method": "midpoints"}))


@dataclass(frozen=True)
class NoMethod(Formulation):
    """Fields, but no method."""

    softness: float = 1.0


def test_a_class_without_a_method_is_refused():
    for made, told in ((Formulation, "a dataclass"), (NoMethod, "a field with a default")):
        with pytest.raises(InputError, match=told):
            register(made)
