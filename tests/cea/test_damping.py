"""Damping of bodies: ratios that are met, pieces of the pencil, changed parameters, refusals."""

import numpy as np
import pytest
from blocks import alone, assemble, scene_body

from cea.eigen.driver import solve_modes
from cea.eigen.matching import assign
from cea.errors import InputError
from cea.motion import ModalDamping, RayleighDamping

TOP = 1.2
KINDS = {
    "one ratio": {"ratio": 0.02, "max_frequency": 0.95},
    "a table": {"ratios": [0.0, 0.3, 0.999], "frequencies": [0.3, 0.6, 0.9]},
}


def one_block(backend, damping=None, *, held=True, size=(1.0, 0.6), elements=(4, 3)):
    """A block alone, in plane strain."""
    geometry = {"shape": "rectangle", "size": list(size), "origin": [0.0, 0.0]}
    body = scene_body(backend, geometry, list(elements))
    if held:
        body["supports"] = [{"surface": "y_min"}]
    if damping is not None:
        body["damping"] = damping
    return alone(body, TOP)


@pytest.mark.parametrize("frequencies", [(100.0, 2500.0), (2500.0, 100.0)])
def test_ratios_are_met_at_their_frequencies(frequencies):
    ratios = (0.02, 0.03)
    damping = RayleighDamping.of_ratios(ratios, frequencies)
    omega = 2 * np.pi * np.array(frequencies)
    found = damping.alpha / (2 * omega) + damping.beta * omega / 2
    assert found == pytest.approx(ratios, rel=1e-14)


def expected_ratios(kind, frequencies):
    """Damping ratios of elastic modes, as the scene means them."""
    modal = KINDS[kind]
    if "ratio" in modal:
        return np.where(frequencies <= modal["max_frequency"], modal["ratio"], 0.0)
    return np.interp(frequencies, modal["frequencies"], modal["ratios"], right=0.0)


@pytest.mark.grid
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("held", [True, False])
def test_a_body_alone_has_the_ratios_it_is_given(backend, kind, held):
    plain, system = (
        assemble(one_block(backend, damping, held=held))
        for damping in (None, {"modal": KINDS[kind]})
    )
    free = solve_modes(plain.pencil(), TOP).eigenvalues.imag
    omega = free[free > 1e-3]
    assert len(free) - len(omega) == (0 if held else 3)
    zeta = expected_ratios(kind, omega / (2 * np.pi))
    assert (zeta > 0).sum() > 2
    exact = omega * (-zeta + 1j * np.sqrt(1 - zeta**2))
    modes = solve_modes(system.pencil(), TOP, min_growth=-2 * np.pi * TOP)
    elastic = np.abs(modes.eigenvalues) > 1e-3
    found = modes.eigenvalues[elastic]
    assert len(found) == len(exact)
    rows, columns = assign(np.abs(exact[:, None] - found), 1.0)
    assert found[columns] == pytest.approx(exact[rows], rel=1e-10)
    words = np.array(modes.verdicts())[elastic][columns]
    assert set(words[zeta[rows] > 0]) == {"stable"}
    assert set(words[zeta[rows] == 0]) <= {"stable", "undecided"}  # of zero errors leave no sign


def test_modes_of_one_frequency_are_damped_alike(backend):
    """Of a free square some come in pairs, of which any two may be found."""
    square = {"held": False, "size": (1.0, 1.0), "elements": (3, 3)}
    omega = solve_modes(assemble(one_block(backend, **square)).pencil(), 2 * TOP).eigenvalues.imag
    first = 3 + int(np.flatnonzero(np.diff(omega[3:]) < 1e-8 * omega[3:-1])[0])
    for end in omega[first : first + 2]:
        modal = {"ratio": 0.1, "max_frequency": float(end) / (2 * np.pi)}
        pencil = assemble(one_block(backend, {"modal": modal}, **square)).pencil()
        assert len(pencil.low_rank[0].piece.weights) == first + 2 - 3


def test_damped_modes_belong_to_one_material(backend):
    pencil = assemble(one_block(backend, {"modal": KINDS["one ratio"]})).pencil()
    with pytest.raises(InputError, match=r"bodies\.part\.material\.E.*5.*computed"):
        pencil.at({"bodies.part.material.E": 5.0})
    modes = solve_modes(pencil, TOP, left=True)
    with pytest.raises(InputError, match=r"bodies\.part\.material\.rho"):
        modes.sensitivity("bodies.part.material.rho")
    assert np.isfinite(modes.sensitivity("bodies.part.damping.modal.ratio")).all()


@pytest.mark.parametrize("ratios", [(0.01, 0.031), (0.031, 0.01)])
def test_ratios_that_no_damping_has_are_refused(ratios):
    with pytest.raises(InputError, match=r"damping\.ratios"):
        RayleighDamping.of_ratios(ratios, (100.0, 300.0))


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({"ratio": 0.01}, "max_frequency"),
        ({"ratio": 1.0, "max_frequency": 9.0}, "ratio"),
        ({"ratio": 0.1, "max_frequency": 9.0, "ratios": (0.1,)}, "ratio"),
        ({"ratios": (0.1, 3.0), "frequencies": (1.0, 2.0)}, "ratios"),
        ({"ratios": (0.1, 0.2), "frequencies": (2.0, 1.0)}, "frequencies"),
        ({"ratios": (0.1, 0.2), "frequencies": (1.0,)}, "frequencies"),
        ({"ratios": (0.1,), "frequencies": (0.0,)}, "frequencies"),
    ],
)
def test_what_is_no_damping_is_refused(fields, named):
    with pytest.raises(InputError) as told:
        ModalDamping(**fields)
    assert told.value.field == named
