"""Pencils of which maps are made, and what full and dense solves say of them."""

from types import MappingProxyType

import numpy as np
from blocks import assemble, coarse, two_blocks
from petsc_matrices import to_petsc
from scipy.linalg import eig

from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.eigen.parameters import Coefficient, Parameter
from cea.eigen.pencil import FRICTION, Pencil, Term
from cea.reduced.greedy import Enrichment
from cea.reduced.model import ReducedModel
from cea.reduced.small import ModelLine
from cea.reduced.window import upper_root

MU, P = "contacts.interface.mu", "contacts.interface.P"
ALPHA, RATIO = "bodies.upper.damping.alpha", "bodies.lower.damping.modal.ratio"


def enrichment(pencil, box, top, **options):
    """A reduced model of a pencil with nothing in it yet, and what fills it."""
    return Enrichment.of(ReducedModel(pencil, box, top), EigenSolver(pencil), **options)


def kappa_of(found):
    """Kappa of a spectrum."""
    return -(found.eigenvalues**2) if found.settings.window.damped else found.z


def errors_of_means(found, kappa):
    """Errors of the means of clusters of a window, relative to the squares of their speeds."""
    window = found.window
    rows, columns = assign(np.abs(kappa_of(window)[:, None] - kappa))
    assert len(rows) == len(window)
    clusters = window.clusters[rows]
    return np.array(
        [
            abs((kappa_of(window)[rows] - kappa[columns])[clusters == each].mean())
            / (window.speeds[rows][clusters == each].max() ** 2)
            for each in np.unique(clusters)
        ]
    )


def grid(**axes):
    """Points of a product of axes, parameters by the names they have in Python."""
    names = {"mu": MU, "P": P}
    values = np.meshgrid(*axes.values(), indexing="ij")
    columns = [each.ravel().tolist() for each in values]
    keys = [names[name] for name in axes]
    return [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)]


def blocks_pencil(backend, *, method="gpts", stiffness=3.0, **contact):
    """Two small blocks that rub, held at bottom and top."""
    formulation = {"method": method} | ({"points": 3} if method == "gpts" else {})
    scene = coarse(two_blocks(backend, formulation, held=True, P=stiffness))
    scene["contacts"]["interface"] |= contact
    return assemble(scene, leave_out=False).pencil(leave_out=False)


def damped_blocks_pencil(backend, values=None, **contact):
    """Two small blocks that rub, one with Rayleigh damping, the other with that of its modes."""
    at = {P: 3.0, ALPHA: 0.05, RATIO: 0.02} | (values or {})
    scene = two_blocks(backend, {"method": "gpts", "points": 3}, held=True, P=at[P])
    scene = coarse(scene)
    scene["bodies"]["upper"]["damping"] = {"alpha": at[ALPHA], "beta": 0.0}
    modal = {"ratio": at[RATIO], "max_frequency": 0.7}
    scene["bodies"]["lower"]["damping"] = {"modal": modal}
    scene["contacts"]["interface"] |= contact
    return assemble(scene, leave_out=False).pencil(leave_out=False)


def plane_blocks_pencil(backend, contact, *, alpha=0.0):
    """Two plane blocks, held at bottom and top, whose contact forces are unknowns."""

    def body(size, origin, held, E, elements):
        return {
            "backend": backend,
            "geometry": {"shape": "rectangle", "size": size, "origin": origin},
            "material": {"E": E, "nu": 0.3, "rho": 1.0},
            "supports": [{"surface": held}],
            "mesh": {
                "fe": {"cell": "quadrilateral", "degree": 2, "elements": elements},
                "iga": {"degree": [2, 2], "elements": elements},
            },
        }

    lower = body([2.0, 1.0], [0.0, -1.0], "y_min", 1.0, [5, 2])
    upper = body([1.6, 0.4], [0.2, 0.0], "y_max", 0.3, [4, 2])
    if alpha:
        upper["damping"] = {"alpha": alpha, "beta": 0.0}
    data = {
        "name": "plane blocks",
        "bodies": {"upper": upper, "lower": lower},
        "contacts": {"interface": {"a": "upper.y_min", "b": "lower.y_max", "form": "saddle"}},
        "analysis": {"kind": "cea", "max_frequency": 0.5},
    }
    data["contacts"]["interface"] |= contact
    return assemble(data, leave_out=False).pencil(leave_out=False)


def random_pencil(seed, n=90):
    """A dense pencil S - s F, M whose lowest modes flutter at s below one, with its matrices."""
    rng = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(rng.standard_normal((n, n)))
    kappa = np.arange(1.0, n + 1) ** 1.5
    coupling = rng.standard_normal((n, n)) / (1 + 0.05 * np.add.outer(kappa, kappa) ** 0.5)
    root = np.diag(rng.uniform(0.7, 1.4, n))
    S = root @ axes @ np.diag(kappa) @ axes.T @ root
    F = root @ axes @ coupling @ axes.T @ root
    S, M = 0.5 * (S + S.T), root @ root
    return Pencil.of(to_petsc(S), to_petsc(M), to_petsc(F)), (S, M, F)


def dense(matrices, s):
    """Eigenvalues of a dense pencil by rising frequency."""
    S, M, F = matrices
    kappa = eig(S - s * F, M, right=False)
    return kappa[np.argsort(upper_root(kappa).imag)]


def random_damped_pencil(seed, n=40, *, equal=False):
    """A dense pencil of s and Omega, damped and turning, with its matrices.

    Parameters
    ----------
    seed
        Of the random numbers.
    n
        Its size.
    equal
        Whether its damping is 0.04 M, its friction between two modes alone: lambda is known then,
        and the two coalesce at s = 1.
    """
    rng = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(rng.standard_normal((n, n)))
    kappa = np.arange(1.0, n + 1) ** 1.5
    coupling = rng.standard_normal((n, n)) / (1 + 0.05 * np.add.outer(kappa, kappa) ** 0.5)
    if equal:  # kappa^2 - (a + b) kappa + a b + c^2 s^2 has a double root at s = 1
        kappa[:2], coupling = (1.5**2 - 0.3, 1.5**2 + 0.3), np.zeros((n, n))
        coupling[0, 1], coupling[1, 0] = 0.3, -0.3
    root = np.diag(rng.uniform(0.7, 1.4, n))
    S = root @ axes @ np.diag(kappa) @ axes.T @ root
    F = root @ axes @ coupling @ axes.T @ root
    S, M = 0.5 * (S + S.T), root @ root
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
    parameters = [Parameter(FRICTION, 1.0), Parameter("Omega", 0.0)]
    return Pencil(terms, parameters), (S, M, F, C, G)


def dense_damped(matrices, s, turning):
    """Eigenvalues lambda of a dense damped pencil with Im lambda >= 0."""
    S, M, F, C, G = matrices
    nothing, one = np.zeros_like(M), np.eye(len(M))
    first = np.block([[nothing, one], [-(S - s * F), -(C + turning * G)]])
    second = np.block([[one, nothing], [nothing, M]])
    values = eig(first, second, right=False)
    return values[values.imag >= 0]


def map_numbers(backend):
    """What a map of the blocks comes to, in plain numbers that hang on no basis."""
    pencil = blocks_pencil(backend)
    built = enrichment(pencil, {MU: (0.0, 1.0), P: (1.0, 1e4)}, 0.6)
    built.cover(grid(mu=[0.0, 1.0], P=[1.0, 1e4]))
    rows = []
    for point in grid(mu=[0.21, 0.83], P=[3.0, 4e3]):
        found = built.at(point).window
        sums = np.array([found.z.sum(), (found.z**2).sum()])
        rows.append([len(found), *sums.real.tolist()])
    return {"rows": rows, "solves": len(built.solves)}


def model_line(built, name, point=MappingProxyType({}), level=0.0):
    """A reduced model along one parameter, at values of the others."""
    small, pencil = built.model.small, built.model.pencil
    return ModelLine(small, lambda value: pencil.values({**point, name: value}), {name: 1.0}, level)
