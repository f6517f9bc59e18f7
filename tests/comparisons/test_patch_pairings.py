"""Segments and mortar pass the contact patch test between meshes of any kind, wherever they lie."""

from itertools import product

import numpy as np
import pytest

from cea.contact.formulations import Mortar, Segments
from cea.timing import StageTimer
from comparisons.formulations.patch_tests import PRESSURE, PROBLEMS
from scenes import run_scene
from scenes.building.build import build_bodies
from scenes.spec.reading import with_contact

KINDS = ("hexahedra", "tetrahedra", "NURBS")
FLAT, ROTATED = (next(p for p in PROBLEMS if p.name == name) for name in ("flat", "rotated"))
APART = "bodies.upper.placement={translation=[0.0, 0.0, 0.05]}", "contacts.interface.reach=0.06"
WHERE = {
    "flat": (FLAT, ()),
    "rotated": (ROTATED, ()),
    "offset": (FLAT, APART),
    "matching": (FLAT, [f"bodies.upper.mesh.{kind}.elements=[5, 5, 1]" for kind in ("fe", "iga")]),
}
CASES = [
    *product(product(KINDS, KINDS), ("flat", "rotated", "offset")),
    *(((kind, kind), "matching") for kind in ("hexahedra", "NURBS")),
]


def worst_error(pair, where, P, formulations, form="penalty"):
    """Largest relative error of the normal stress of some formulations; bodies are built once."""
    problem, more = WHERE[where]
    scene = problem.scene(pair, P, [*more, f"contacts.interface.form='{form}'"])
    bodies = build_bodies(scene, StageTimer())
    results = [
        run_scene(with_contact(scene, formulation=each), bodies=bodies) for each in formulations
    ]
    sides = [side for result in results for side in result.stresses["interface"].values()]
    return max(np.abs(side.sigma_n / -PRESSURE - 1).max() for side in sides)


@pytest.mark.grid
@pytest.mark.parametrize(("pair", "where"), CASES, ids=str)
def test_exact_integration_passes(pair, where):
    assert worst_error(pair, where, 1e6, (Segments(), Mortar())) < 1e-10


@pytest.mark.grid
@pytest.mark.parametrize("P", [1e2, 1e20, float("inf")])
@pytest.mark.parametrize("pair", [("tetrahedra", "NURBS"), ("NURBS", "hexahedra")])
def test_in_the_saddle_form_at_any_stiffness(pair, P):
    assert worst_error(pair, "rotated", P, (Mortar(),), "saddle") < 1e-8
