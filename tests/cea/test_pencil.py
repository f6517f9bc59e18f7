"""The parametric pencil: the matrices of a changed scene without assembling it again."""

import numpy as np
import pytest
from blocks import assemble, two_blocks
from covering import covering
from petsc_matrices import dense_pencil, to_numpy, to_petsc

from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.driver import EigenSolver
from cea.eigen.pencil import FRICTION, Pencil, Term
from cea.errors import InputError

GPTS = {"method": "gpts", "points": 3}


def scene(backend, *, form="penalty", full_pass=False, E=2.0, rho=1.5, P=3.0, mu=0.4, springs=()):
    data = two_blocks(backend, GPTS, mu=mu, P=P, held=True)
    data["contacts"]["interface"] |= {"form": form, "full_pass": full_pass}
    data["bodies"]["upper"]["material"] |= {"E": E, "rho": rho}
    data["bodies"]["upper"]["springs"] = list(springs)
    return assemble(data)


CHANGES = {
    "bodies.upper.material.E": {"E": 5.0},
    "bodies.upper.material.rho": {"rho": 0.7},
    "contacts.interface.P": {"P": 40.0},
    "contacts.interface.mu": {"mu": 0.9},
}


@pytest.mark.parametrize(
    ("backend", "form", "full_pass", "name"),
    covering(["fe", "iga"], ["penalty", "saddle"], [False, True], list(CHANGES)),
)
def test_a_changed_parameter_gives_the_matrices_of_a_changed_scene(backend, form, full_pass, name):
    spring = {"surface": "x_min", "stiffness": [0.3, 0.2, 0.1]}
    options, change = {"form": form, "full_pass": full_pass, "springs": [spring]}, CHANGES[name]
    changed = scene(backend, **options).pencil().at({name: next(iter(change.values()))})
    assembled = scene(backend, **options, **change).pencil().at()
    for part in ("stiffness", "unsymmetric", "mass"):
        ours, theirs = getattr(changed, part), getattr(assembled, part)
        if form == "saddle" and part == "unsymmetric":
            assert ours is theirs is None
            continue
        expected = to_numpy(theirs)
        assert np.abs(to_numpy(ours) - expected).max() <= 1e-13 * np.abs(expected).max()
    ours, theirs = (dense_pencil(each)[2] for each in (changed, assembled))
    assert np.abs(ours - theirs).max() <= 1e-11 * np.abs(theirs).max()


def test_two_contacts_have_their_own_friction(backend):
    data = two_blocks(backend, GPTS, mu=0.4)
    first = data["contacts"]["interface"]
    data["contacts"]["again"] = first | {"mu": 0.2, "P": 7.0}
    pencil = assemble(data, together=False).pencil()
    one, both = (
        to_numpy(pencil.at(changes).unsymmetric)
        for changes in ({"contacts.again.mu": 0.0}, {"contacts.again.mu": 0.8})
    )
    # Equal points: the second adds 7/3 * 0.8/0.4 of what the first is.
    expected = one * (1 + 7 / 3 * 2)
    assert (np.abs(both - expected) <= np.maximum(1e-12 * np.abs(expected), 1e-15)).all()


def test_friction_that_varies_is_changed_by_a_factor(backend):
    data = two_blocks(backend, GPTS)
    data["contacts"]["interface"]["mu"] = "0.3 + 0.1*x"
    system = assemble(data)
    parameter = system.pencil().parameter("contacts.interface.mu")
    assert parameter.value == 1.0
    twice = system.pencil().at({"contacts.interface.mu": 2.0}).unsymmetric
    assert (to_numpy(twice) == -2 * to_numpy(system.contacts[0].K_f)).all()


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"contacts.interface.nu": 0.1}, "contacts.interface.mu"),
        ({"contacts.interface.mu": -0.1}, "zero or positive"),
        ({"contacts.interface.mu": float("nan")}, "zero or positive"),
        ({"contacts.interface.P": 0.0}, "positive"),
        ({"contacts.interface.P": float("inf")}, "finite"),
        ({"bodies.upper.material.E": float("inf")}, "finite"),
    ],
)
def test_parameters_that_cannot_be_are_refused(changes, told):
    pencil = scene("iga").pencil()
    with pytest.raises(InputError, match=told):
        pencil.at(changes)


def test_a_coefficient_must_name_parameters_that_are_there():
    with pytest.raises(InputError, match="Omega"):
        Pencil([Term("stiffness", to_petsc(np.eye(2)), Coefficient.of({"Omega": (1.0, 2.0)}))])


def test_given_matrices_have_one_parameter():
    stiffness, friction = np.diag([2.0, 3.0]), np.array([[0.0, 1.0], [-1.0, 0.0]])
    pencil = Pencil.of(to_petsc(stiffness), to_petsc(np.eye(2)), to_petsc(friction))
    operator = to_numpy(pencil.at({FRICTION: 0.5}).operator(1.0))
    assert (operator == stiffness - 0.5 * friction - np.eye(2)).all()


def test_damping_and_rotation_are_sums_too():
    random = np.random.default_rng(4)
    n = 5
    M, K, C = (part @ part.T for part in random.standard_normal((3, n, n)))
    Y = random.standard_normal((n, n))
    Y = Y - Y.T
    omega = Coefficient.of({"Omega": (1.0, 1.0)})
    pencil = Pencil(
        [
            Term("mass", to_petsc(M)),
            Term("damping", to_petsc(C)),
            Term("damping", to_petsc(Y), omega, symmetric=False),
            Term("stiffness", to_petsc(K)),
        ],
        [Parameter("Omega", 2.0)],
    )
    matrices = pencil.at()
    assert matrices.quadratic
    assert to_numpy(matrices.damping) == pytest.approx(C)
    assert to_numpy(matrices.gyroscopic) == pytest.approx(2 * Y)
    with EigenSolver(pencil) as driver:
        assert driver.matrices().quadratic
        assert driver.solve(1.0).residuals.max() < 1e-13
