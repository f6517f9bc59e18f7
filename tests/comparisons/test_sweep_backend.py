"""Commands with every body of a scene on one backend."""

import pytest

from cea.errors import InputError
from comparisons.cli.options import with_backend
from scenes.spec.reading import load_scene

COARSE = (
    "bodies.upper.mesh.fe.elements=[6,2]",
    "bodies.lower.mesh.fe.elements=[5,2]",
    "bodies.upper.mesh.iga.elements=[6,2]",
    "bodies.lower.mesh.iga.elements=[5,2]",
    "analysis.max_frequency=0.3",
)


def test_every_body_is_put_on_the_backend(backend):
    made = with_backend("blocks", COARSE, backend)
    assert made[: len(COARSE)] == COARSE
    assert load_scene("blocks", made) == load_scene("blocks", COARSE, backend)


def test_without_a_backend_the_scene_is_as_it_says():
    assert with_backend("blocks", COARSE, None) == COARSE


def test_scenes_of_matrices_are_refused(backend):
    with pytest.raises(InputError, match="no bodies"):
        with_backend("tu_berlin", (), backend)
