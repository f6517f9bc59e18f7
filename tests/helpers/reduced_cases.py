"""Pencils of which maps are made, and what full and dense solves say of them."""

import numpy as np
from blocks import assemble, block, two_blocks
from petsc_matrices import to_petsc
from scipy.linalg import eig

from cea.eigen.krylov_schur import KrylovSchur
from cea.eigen.pencil import Pencil
from cea.reduced.greedy import Enrichment
from cea.reduced.model import ReducedModel
from cea.reduced.spectrum import upper_root

MU, P = "contacts.interface.mu", "contacts.interface.P"


def enrichment(pencil, box, top, **options):
    """A reduced model of a pencil with nothing in it yet, and what fills it."""
    return Enrichment(ReducedModel(pencil, box, top), KrylovSchur(pencil), top, **options)


def grid(**axes):
    """Points of a product of axes, parameters by the names they have in Python."""
    names = {"mu": MU, "P": P}
    values = np.meshgrid(*axes.values(), indexing="ij")
    columns = [each.ravel().tolist() for each in values]
    keys = [names[name] for name in axes]
    return [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)]


def coarse(scene):
    """A scene of two blocks with as few elements as do not match."""
    for name, elements in (("upper", [2, 2, 1]), ("lower", [3, 3, 1])):
        for mesh in scene["bodies"][name]["mesh"].values():
            mesh["elements"] = elements
    return scene


def blocks_pencil(backend, *, method="gpts", stiffness=3.0, **contact):
    """Two small blocks that rub, held at bottom and top."""
    formulation = {"method": method} | ({"points": 3} if method == "gpts" else {})
    scene = coarse(two_blocks(backend, formulation, held=True, P=stiffness))
    scene["contacts"]["interface"] |= contact
    return assemble(scene, leave_out=False).pencil(leave_out=False)


def three_blocks_pencil(backend):
    """A block between two others: two contacts, each with its mu."""
    data = coarse(two_blocks(backend, {"method": "gpts", "points": 3}, held=True))
    data["bodies"]["top"] = block(
        backend,
        [0.5, 0.6, 0.2],
        [0.2, 0.3, 0.7],
        [2, 2, 1],
        supports=[{"surface": "z_max"}],
    )
    data["bodies"]["upper"]["supports"] = []
    data["contacts"]["other"] = data["contacts"]["interface"] | {
        "a": "upper.z_max",
        "b": "top.z_min",
        "mu": 0.3,
        "friction_direction_on_a": {"vector": [1.0, -0.4, 0.0]},
    }
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


def map_numbers(backend):
    """What a map of the blocks comes to, in plain numbers that hang on no basis."""
    pencil = blocks_pencil(backend)
    built = enrichment(pencil, {MU: (0.0, 1.0), P: (1.0, 1e4)}, 0.6)
    built.cover(grid(mu=[0.0, 0.5, 1.0], P=[1.0, 1e2, 1e4]))
    rows = []
    for point in grid(mu=[0.21, 0.83], P=[3.0, 4e3]):
        found = built.at(point).window
        sums = np.array([found.kappa.sum(), (found.kappa**2).sum()])
        rows.append([len(found), *sums.real.tolist()])
    return {"rows": rows, "solves": len(built.snapshots)}
