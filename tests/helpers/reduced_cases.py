"""Pencils of which maps are made, and what full and dense solves say of them."""

from types import MappingProxyType

import numpy as np
from blocks import assemble, coarse, rectangle, two_blocks
from petsc_matrices import to_petsc
from scipy.linalg import eig

from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.eigen.pencil import FRICTION, Pencil, Term
from cea.reduced.full_solves import line_of_model
from cea.reduced.greedy import Enrichment
from cea.reduced.model import ReducedModel

MU, P = "contacts.interface.mu", "contacts.interface.P"
ALPHA, RATIO = "bodies.upper.damping.alpha", "bodies.lower.damping.modal.ratio"


def enrichment(pencil, box, top, **options):
    """A reduced model of a pencil with nothing in it yet, and what fills it."""
    return Enrichment(ReducedModel(pencil, box, top), EigenSolver(pencil), **options)


def z_of(found, eigenvalues):
    """Lambda as the z of a spectrum: kappa without damping."""
    return eigenvalues if found.settings.window.damped else -(eigenvalues**2)


def of_clusters(found, z):
    """Errors of the means of clusters of a window, and of bounds, relative to speeds."""
    window = found.window
    rows, columns = assign(np.abs(window.z[:, None] - z))
    assert len(rows) == len(window)
    power = 1 if found.settings.window.damped else 2
    errors, bounds = [], []
    for number in np.unique(window.clusters):
        own = window.clusters[rows] == number
        speed = window.speeds[rows][own].max() ** power
        errors.append(abs((window.z[rows] - z[columns])[own].mean()) / speed)
        bounds.append(window.means[rows][own].max() / speed)
    return np.array(errors), np.array(bounds)


def grid(**axes):
    """Points of a product of axes, parameters by the names they have in Python."""
    names = {"mu": MU, "P": P}
    values = np.meshgrid(*axes.values(), indexing="ij")
    columns = [each.ravel().tolist() for each in values]
    keys = [names[name] for name in axes]
    return [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)]


def blocks_pencil(backend, *, method="gpts", stiffness=3.0, damping=None, **contact):
    """Two small blocks that rub, held at bottom and top.

    ``damping`` gives one Rayleigh damping alpha, the other the ratio of its modes.
    """
    formulation = {"method": method} | ({"points": 3} if method == "gpts" else {})
    scene = coarse(two_blocks(backend, formulation, held=True, P=stiffness))
    if damping is not None:
        alpha, ratio = damping
        scene["bodies"]["upper"]["damping"] = {"alpha": alpha, "beta": 0.0}
        modal = {"ratio": ratio, "max_frequency": 0.7}
        scene["bodies"]["lower"]["damping"] = {"modal": modal}
    scene["contacts"]["interface"] |= contact
    return assemble(scene, leave_out=False).pencil(leave_out=False)


def plane_blocks_pencil(backend, contact, *, alpha=0.0):
    """Two plane blocks, held at bottom and top, whose contact forces are unknowns."""
    shapes = {
        "lower": ([2.0, 1.0], [5, 2], (0.0, -1.0), 1.0, "y_min"),
        "upper": ([1.6, 0.4], [4, 2], (0.2, 0.0), 0.3, "y_max"),
    }
    bodies = {}
    for name, (size, elements, origin, E, held) in shapes.items():
        sections = {"material": {"E": E, "nu": 0.3, "rho": 1.0}, "supports": [{"surface": held}]}
        bodies[name] = rectangle(backend, size, elements, origin=origin, **sections)
    if alpha:
        bodies["upper"]["damping"] = {"alpha": alpha, "beta": 0.0}
    interface = {"a": "upper.y_min", "b": "lower.y_max", "form": "saddle"} | contact
    data = {
        "name": "plane blocks",
        "bodies": bodies,
        "contacts": {"interface": interface},
        "analysis": {"kind": "cea", "max_frequency": 0.5},
    }
    return assemble(data, leave_out=False).pencil(leave_out=False)


def random_pencil(seed, *, damped=False, equal=False, lowered=0.0):
    """A dense pencil S - s F of friction s whose lowest modes flutter below one.

    And its eigenvalues: kappa at s, or lambda with Im lambda >= 0 at s and Omega where it is
    ``damped`` and turns with Omega. Where modes are ``equal`` its damping is 0.04 M, its friction
    between two modes alone: lambda is known then, and the two coalesce at s = 1. Where kappa is
    ``lowered`` the stiffness is not positive.
    """
    rng, n = np.random.default_rng(seed), 40 if damped else 90
    axes, _ = np.linalg.qr(rng.standard_normal((n, n)))
    kappa = np.arange(1.0, n + 1) ** 1.5
    coupling = rng.standard_normal((n, n)) / (1 + 0.05 * np.add.outer(kappa, kappa) ** 0.5)
    if equal:  # kappa^2 - (a + b) kappa + a b + c^2 s^2 has a double root at s = 1
        kappa[:2], coupling = (1.5**2 - 0.3, 1.5**2 + 0.3), np.zeros((n, n))
        coupling[0, 1], coupling[1, 0] = 0.3, -0.3
    root = np.diag(rng.uniform(0.7, 1.4, n))
    S = root @ axes @ np.diag(kappa - lowered) @ axes.T @ root
    F = root @ axes @ coupling @ axes.T @ root
    S, M = 0.5 * (S + S.T), root @ root
    if not damped:
        return Pencil.of(to_petsc(S), to_petsc(M), to_petsc(F)), lambda s: eig(S - s * F, M)[0]
    part = rng.standard_normal((n, n)) / n
    C, G = (0.04 * M, 0 * M) if equal else (0.02 * M + part @ part.T, part - part.T)
    s, turning = Coefficient.of({FRICTION: (1.0, 1.0)}, -1.0), Coefficient.of({"Omega": (1.0, 1.0)})
    terms = [
        Term("stiffness", to_petsc(S)),
        Term("mass", to_petsc(M)),
        Term("stiffness", to_petsc(F), s, symmetric=False),
        Term("damping", to_petsc(C)),
        Term("damping", to_petsc(G), turning, symmetric=False),
    ]

    def dense(s, turning=0.0):
        nothing, one = np.zeros_like(M), np.eye(n)
        first = np.block([[nothing, one], [-(S - s * F), -(C + turning * G)]])
        values = eig(first, np.block([[one, nothing], [nothing, M]]), right=False)
        return values[values.imag >= 0]

    return Pencil(terms, [Parameter(FRICTION, 1.0), Parameter("Omega", 0.0)]), dense


def model_line(built, name, point=MappingProxyType({}), level=0.0):
    """A reduced model along one parameter, at values of the others."""
    small, pencil = built.model.small, built.model.pencil
    rates = {name: 1.0}
    return line_of_model(small, lambda value: pencil.values({**point, name: value}), rates, level)
