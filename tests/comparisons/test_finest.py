"""The finest meshes of the accuracy study against every eigenvalue of the reference files."""

from itertools import product

import numpy as np
import pytest
from reference_data import eigenvalues, stored

from comparisons.accuracy.finest import COMPARED, FINEST, Finest, both_signs, measure

NAMES = {"drum": "drum_2d", "blocks": "blocks_sine_mu", "ring": "ring_rollers"}


def stored_families(problem, p, mu):
    """Listed eigenvalues of a problem by harmonic; computed ones where none are listed."""
    compared = COMPARED[problem]
    found = {}
    for entry in stored(NAMES[problem]):
        m = entry.get("m")
        friction = entry["mu"] if "mu" in entry else entry["mu0"]
        if (float(entry["p"]), float(friction)) != (p, mu) or entry.get("kz") is not None:
            continue
        if m in compared.orders:
            found["all" if m is None else f"m = {m}"] = both_signs(
                eigenvalues(entry)[: compared.count], m
            )
    assert len(found) in (0, len(compared.orders))
    return found or compared.families(p, mu)


def every_case():
    """Finest meshes with each stiffness and friction they are compared at."""
    for finest in FINEST:
        compared = COMPARED[finest.problem]
        for p, mu in product(compared.stiffnesses, compared.frictions):
            quick = finest.problem == "blocks" and mu == 0.7 and p <= 10
            marks = [] if quick else [pytest.mark.slow]
            name = f"{finest.problem}-{finest.backend}-{p:g}-{mu:g}"
            yield pytest.param(finest, p, mu, id=name, marks=marks)


@pytest.mark.grid(quick=2)
@pytest.mark.parametrize(("finest", "p", "mu"), list(every_case()))
def test_every_listed_eigenvalue_is_found_to_its_digits(finest, p, mu):
    families = stored_families(finest.problem, p, mu)
    run = measure(finest, p, mu, families)
    assert run["compared"] == sum(map(len, families.values()))
    assert run["worst"] is not None, run["errors"]
    assert run["worst"] < finest.bound, run["errors"]


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("problem", ["drum", "blocks"])
def test_what_the_study_compares_is_what_is_listed(problem):
    compared = COMPARED[problem]
    p, mu = 1.0, compared.frictions[0]
    families = stored_families(problem, p, mu)
    name = list(families)[-1]
    single = type(compared)(
        compared.solver, compared.orders[-1:], compared.stiffnesses, compared.frictions
    )
    values = single.families(p, mu)[name]
    assert len(values) >= len(families[name])
    distance = np.abs(values[:, None] - families[name]).min(axis=0)
    assert distance.max() < 1e-12


def test_a_coarse_mesh_is_told_from_a_fine_one():
    coarse = Finest("blocks", "iga", 3, {"upper": (10, 2), "lower": (7, 3)}, 1e-10)
    run = measure(coarse, 1.0, 0.3, stored_families("blocks", 1.0, 0.3))
    assert 1e-8 < run["worst"] < 1e-3
    assert run["errors"] == {"all": run["worst"]}
    low = {"low": stored_families("blocks", 1.0, 0.3)["all"][:4]}
    assert measure(coarse, 1.0, 0.3, low)["worst"] < run["worst"]
    lost = measure(coarse, 1.0, 0.3, {"none": np.array([2.0j])})
    assert lost["errors"] == {"none": None}
    assert lost["worst"] is None
