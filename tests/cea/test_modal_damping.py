"""Modal damping of bodies: what is damped, by which matrix, and what is refused."""

import numpy as np
import pytest
from blocks import alone, assemble, scene_body
from covering import covering

from cea.eigen.driver import solve_modes
from cea.eigen.matching import assign
from cea.errors import InputError
from cea.motion import ModalDamping

TOP = 1.2


def one_block(backend, modal=None, *, held=True, size=(1.0, 0.6), elements=(4, 3), **material):
    """A block alone, in plane strain."""
    geometry = {"shape": "rectangle", "size": list(size), "origin": [0.0, 0.0]}
    body = scene_body(backend, geometry, list(elements))
    body["material"] |= material
    if held:
        body["supports"] = [{"surface": "y_min"}]
    if modal is not None:
        body["damping"] = {"modal": modal}
    return alone(body, TOP)


def piece_of(system):
    """W diag(d) W^T of a system as a full matrix."""
    root = system.pencil().at().low_rank.vectors
    return root @ root.T


KINDS = {
    "one ratio": {"ratio": 0.02, "max_frequency": 0.95},
    "a list": {"ratios": [0.5, 1e-6, 0.9, 0.999]},
    "a table": {"ratios": [0.0, 0.3, 0.1], "frequencies": [0.3, 0.6, 0.9]},
}
EVERY = {"one ratio, far beyond all modes": {"ratio": 0.999, "max_frequency": 1e3}}


def expected_ratios(kind, frequencies):
    """Damping ratios of elastic modes, as the scene means them."""
    modal = (KINDS | EVERY)[kind]
    if "ratio" in modal:
        return np.where(frequencies <= modal["max_frequency"], modal["ratio"], 0.0)
    if kind == "a list":
        return np.pad(modal["ratios"], (0, len(frequencies) - 4))
    return np.interp(frequencies, modal["frequencies"], modal["ratios"], right=0.0)


@pytest.mark.parametrize(
    ("backend", "kind", "held"), covering(["iga", "fe"], list(KINDS), [True, False], strength=1)
)
def test_a_body_alone_has_the_ratios_it_is_given(backend, kind, held):
    plain, system = (
        assemble(one_block(backend, modal, held=held)) for modal in (None, KINDS[kind])
    )
    free = solve_modes(plain.pencil(), TOP).eigenvalues.imag
    omega = free[free > 1e-3]
    assert len(free) - len(omega) == (0 if held else 3)
    zeta = expected_ratios(kind, omega / (2 * np.pi))
    assert (zeta > 0).sum() > 2
    exact = omega * (-zeta + 1j * np.sqrt(1 - zeta**2))
    modes = solve_modes(system.pencil(), TOP, min_growth=-2 * np.pi * TOP)
    found = modes.eigenvalues[np.abs(modes.eigenvalues) > 1e-3]
    assert len(found) == len(exact)
    rows, columns = assign(np.abs(exact[:, None] - found), 1.0)
    assert found[columns] == pytest.approx(exact[rows], rel=1e-10)
    words = np.array(modes.verdicts())[np.abs(modes.eigenvalues) > 1e-3][columns]
    assert set(words[zeta[rows] > 0]) == {"stable"}
    assert set(words[zeta[rows] == 0]) <= {"stable", "undecided"}  # of zero errors leave no sign


def test_modes_of_one_frequency_are_damped_alike(backend):
    """Of a free square some come in pairs, of which any two may be found."""
    square = {"held": False, "size": (1.0, 1.0), "elements": (3, 3)}
    plain = assemble(one_block(backend, **square))
    omega = solve_modes(plain.pencil(), 2 * TOP).eigenvalues.imag[3:]
    first = int(np.flatnonzero(np.diff(omega) < 1e-8 * omega[:-1])[0])
    alike = [0.01 * i for i in range(first)] + [0.5, 0.5]
    assemble(one_block(backend, {"ratios": alike}, **square)).pencil()
    told = rf"damping\.modal\.ratios.*modes {first + 1} to {first + 2}"
    for ratios in (alike[:-1], [*alike[:-1], 0.6]):
        with pytest.raises(InputError, match=told):
            assemble(one_block(backend, {"ratios": ratios}, **square)).pencil()


def test_more_ratios_than_modes_are_refused(backend):
    system = assemble(one_block(backend, held=False))
    size = system.bodies["part"].mass().getSize()[0]
    for count in (size - 2, size + 1):
        data = one_block(backend, {"ratios": [0.01] * count}, held=False)
        with pytest.raises(InputError, match=r"bodies\.part\.damping\.modal\.ratios"):
            assemble(data).pencil()
    every = one_block(backend, {"ratios": [0.01] * (size - 3)}, held=False)
    assert len(assemble(every).pencil().low_rank[0].piece.weights) == size - 3


@pytest.mark.parametrize("change", [{"E": 5.0}, {"rho": 0.7}])
def test_modes_that_are_counted_follow_the_material(backend, change):
    name, value = next(iter(change.items()))
    modal = KINDS["a list"]
    values = {f"bodies.part.material.{name}": value}
    system = assemble(one_block(backend, modal))
    changed = system.pencil().at(values).low_rank.vectors
    expected = piece_of(assemble(one_block(backend, modal, **change)))
    assert changed @ changed.T == pytest.approx(expected, abs=1e-11 * np.abs(expected).max())


def test_modes_that_are_not_counted_do_not(backend):
    system = assemble(one_block(backend, KINDS["one ratio"]))
    pencil = system.pencil()
    with pytest.raises(InputError, match=r"bodies\.part\.material\.E.*5.*found"):
        pencil.at({"bodies.part.material.E": 5.0})
    modes = solve_modes(pencil, TOP, left=True)
    with pytest.raises(InputError, match=r"bodies\.part\.material\.rho"):
        modes.sensitivity("bodies.part.material.rho")
    assert np.isfinite(modes.sensitivity("bodies.part.damping.modal.ratio")).all()


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({}, "ratio"),
        ({"ratio": 0.01}, "max_frequency"),
        ({"ratio": 0.01, "max_frequency": 0.0}, "max_frequency"),
        ({"ratio": 0.01, "max_frequency": np.inf}, "max_frequency"),
        ({"ratio": 1.0, "max_frequency": 9.0}, "ratio"),
        ({"ratio": -0.1, "max_frequency": 9.0}, "ratio"),
        ({"ratio": 0.1, "max_frequency": 9.0, "ratios": (0.1,)}, "ratio"),
        ({"max_frequency": 9.0, "ratios": (0.1,)}, "max_frequency"),
        ({"ratio": 0.1, "max_frequency": 9.0, "frequencies": (1.0,)}, "frequencies"),
        ({"ratios": ()}, "ratios"),
        ({"ratios": (0.1, 3.0)}, "ratios"),
        ({"ratios": (0.1, np.nan)}, "ratios"),
        ({"ratios": (0.1, 0.2), "frequencies": (2.0, 1.0)}, "frequencies"),
        ({"ratios": (0.1, 0.2), "frequencies": (1.0,)}, "frequencies"),
        ({"ratios": (0.1,), "frequencies": (0.0,)}, "frequencies"),
        ({"frequencies": (1.0, 2.0)}, "ratio"),
    ],
)
def test_what_is_no_damping_is_refused(fields, named):
    with pytest.raises(InputError) as told:
        ModalDamping(**fields)
    assert told.value.field == named
