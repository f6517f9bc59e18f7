"""Mortar contact beside exact eigenvalues at every stiffness, tied too: it does not lock."""

from functools import cache
from math import inf, tau

import numpy as np
import pytest

from cea.eigen.matching import match_spectrum
from scenes import run_modes
from scenes.spec.reading import load_scene

pytest.importorskip("flint")

STIFFNESSES = (1e-2, 1e-1, 1.0, 1e1, 1e2, 1e4, 1e6, 1e9, 1e12, inf)
MESHES = {
    "blocks": {"upper": {"fe": [8, 2], "iga": [10, 3]}, "lower": {"fe": [7, 4], "iga": [9, 6]}},
    "drum": {"outer": {"fe": [2, 16], "iga": [2, 24]}, "inner": {"fe": [2, 14], "iga": [2, 20]}},
}
TOP = {"blocks": 2.2, "drum": 1.7}
"""Highest Im lambda of the exact eigenvalues looked at."""
LOWEST = 6
"""Modes that are compared: of a band more are counted the softer the contact."""
REACH = 0.1


@cache
def exact(problem, p):
    from exact_cea.reference import whole_spectrum

    values = whole_spectrum(problem, max_frequency=TOP[problem], p=p, mu=0.3).values
    return values[np.lexsort((values.real, values.imag))][:LOWEST]


def error(problem, backend, p, form):
    """Largest error of the lowest eigenvalues, relative to their moduli."""
    fields = {"contacts.interface.p": p, "contacts.interface.form": form}
    fields["analysis.max_frequency"] = (1 + REACH) * TOP[problem] / tau
    for body, elements in MESHES[problem].items():
        degree = {"fe": 3, "iga": [3, 3]}[backend]
        fields[f"bodies.{body}.mesh.{backend}.elements"] = elements[backend]
        fields[f"bodies.{body}.mesh.{backend}.degree"] = degree
    result = run_modes(load_scene(problem, [], backend).change(fields))
    match = match_spectrum(result.eigenvalues, exact(problem, p), reach=REACH)
    assert len(match.errors) == LOWEST
    return float(match.errors.max())


@pytest.mark.parametrize(
    ("problem", "stiffnesses"),
    [
        ("blocks", (1e-2, 1.0, 1e6, inf)),
        pytest.param("blocks", STIFFNESSES, marks=pytest.mark.slow),
        pytest.param("drum", STIFFNESSES, marks=pytest.mark.slow),
    ],
)
def test_the_error_is_that_of_unit_stiffness(problem, backend, stiffnesses):
    errors = np.array([error(problem, backend, p, "saddle") for p in stiffnesses])
    unit = errors[stiffnesses.index(1.0)]
    assert unit < {"fe": 1e-4, "iga": 1e-4}[backend]
    assert errors.max() <= 2 * unit
