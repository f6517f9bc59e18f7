"""Cases of matrices and meshes from files, and of contacts whose surfaces turn a corner."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.linalg import block_diag, eigvals, qr

from cea.arrays import Complexes, Floats
from cea.mesh import Mesh
from comparisons.stability.case import EXPECTED, Run, Runs, formula, runs
from comparisons.stability.dense import lambdas
from comparisons.stability.problems import WRITERS, Answer, OfFiles, OfScene, StressAnswer
from comparisons.stability.scenes import (
    Scene,
    body,
    contact,
    layers,
    pad,
    patch,
    rectangle,
    scene,
    up_to,
)
from comparisons.stability.ways import ALONE, PAIR, SADDLE, WAYS, chosen
from meshes.breaks import breaks_of
from meshes.mesh_file import METRES, Unit
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Rectangle


@dataclass(frozen=True)
class Block:
    """Two unknowns: (lambda^2 + (c -+ i g) lambda + k -+ i f) = 0."""

    k: float  # stiffness (1/s^2)
    c: float = 0.0  # damping (1/s)
    g: float = 0.0  # gyroscopic coupling (1/s)
    f: float = 0.0  # circulatory coupling (1/s^2)

    def eigenvalues(self) -> Complexes:
        """Its four eigenvalues."""
        signs = np.array([1j, -1j])
        half, rest = 0.5 * (self.c - signs * self.g), self.k - signs * self.f
        root = np.sqrt(half**2 - rest + 0j)
        larger = -half - np.where((half.conj() * root).real >= 0, root, -root)
        return np.concatenate([larger, rest / larger])  # avoids cancellation


def _matrices(blocks: Sequence[Block]) -> dict[str, Floats]:
    """M, C and K of blocks, shape (2 n, 2 n)."""
    one, turn = np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]])
    return {
        "M": np.eye(2 * len(blocks)),
        "C": block_diag(*(b.c * one + b.g * turn for b in blocks)),
        "K": block_diag(*(b.k * one + b.f * turn for b in blocks)),
    }


def _transformed(matrices: Mapping[str, Floats], change: Floats) -> dict[str, Floats]:
    """The same system in other unknowns, T^T A T; symmetric matrices stay exactly symmetric."""
    changed = {}
    for name, matrix in matrices.items():
        product = change.T @ matrix @ change
        symmetric = (matrix == matrix.T).all()
        changed[name] = 0.5 * (product + product.T) if symmetric else product
    return changed


def _upper(blocks: Sequence[Block]) -> Complexes:
    """Eigenvalues of blocks with Im lambda >= 0."""
    values = np.concatenate([block.eigenvalues() for block in blocks])
    return values[values.imag >= 0]


_STIFFNESSES = np.linspace(1.0, 60.0, 12)
_PLAIN = tuple(Block(k) for k in _STIFFNESSES)
_UNDAMPED = tuple(Block(k, f=0.3 if 4 < k < 12 else 0.0) for k in _STIFFNESSES)
"""Undamped blocks, some of which flutter."""
_DAMPED = tuple(replace(block, c=0.02, g=0.1) for block in _UNDAMPED)
_N = 2 * len(_DAMPED)


def _mixing(n: int, seed: int, size: float) -> Floats:
    return np.eye(n) + size * np.random.default_rng(seed).standard_normal((n, n)) / np.sqrt(n)


_MIXED = _mixing(_N, 5, 0.4)


def _run(
    row: str, true: Any, matrices: Mapping[str, Floats], *, form: str = "npz", **fields: Any
) -> Run:
    """A run of matrices in files; ``true``: blocks, eigenvalues, or None if they are refused."""
    given: dict[str, Any] = {"lowest": 12, "warnings": (), "expected": "accurate"} | fields
    if true is None:
        given |= {"expected": "refused", "names": "positive definite"}
    elif not isinstance(true, np.ndarray):
        true = _upper(true)
    reference = None if true is None else formula(true.tolist())
    may = EXPECTED[given.pop("expected")]
    return Run(row, ALONE[0], OfFiles(matrices, form), reference, may, **given)


def _units() -> Runs:
    """Yield runs with other units of unknowns and of time."""
    mixed = _transformed(_matrices(_DAMPED), _MIXED)
    for form in WRITERS:
        yield _run(f"damped, rotating, with friction: .{form}", _DAMPED, mixed, form=form)
    undamped = _transformed(_matrices(_PLAIN), _MIXED)
    yield _run("neither damped nor rotating", _PLAIN, undamped)
    for digits in (3, 6, 9, 12):
        scaled = _transformed(mixed, np.diag(np.geomspace(10.0**-digits, 10.0**digits, _N)))
        yield _run(f"units of unknowns 1e-{digits} to 1e{digits}", _DAMPED, scaled)
    for time in (1e-9, 1e-4, 1e4, 1e9):
        faster = tuple(Block(b.k / time**2, b.c / time, b.g / time, b.f / time**2) for b in _DAMPED)
        matrices = {"M": mixed["M"], "C": mixed["C"] / time, "K": mixed["K"] / time**2}
        yield _run(f"unit of time {time:.0e} s", faster, matrices)


def _masses() -> Runs:
    """Yield runs with tiny masses, whose modes are far beyond the window, and singular ones."""
    for mass in (1e-3, 1e-6, 1e-9, 1e-12):
        blocks = (*_DAMPED, Block(5.0 / mass))
        matrices = _matrices(blocks)
        for name in ("M", "K"):
            matrices[name][-2:, -2:] *= mass
        change = np.eye(_N + 2)
        change[:_N, :_N] = _MIXED
        change[-2:, :_N] = 0.1
        yield _run(f"masses of {mass:.0e} beside 1", blocks, _transformed(matrices, change))
    for number in (1, 5):
        matrices = _matrices(_DAMPED)
        matrices["M"][:number, :number] = 0.0
        yield _run(f"{number} unknowns without mass", None, matrices)
        yield _run(f"{number} motions without mass", None, _transformed(matrices, _MIXED))


def _clusters() -> Runs:
    """Yield runs with multiple eigenvalues and Jordan blocks, with errors of sqrt(rounding)."""
    equal = (Block(4.0, c=0.02, f=0.1),) * 10 + (Block(9.0, c=0.02),) * 10 + _DAMPED
    matrices = _matrices(equal)
    mixed = _transformed(matrices, _mixing(2 * len(equal), 6, 0.3))
    yield _run("10 copies of two, as they are", equal, matrices, lowest=45)
    yield _run("10 copies of two, mixed", equal, mixed, lowest=45)
    for coupling in (1.0, 1e-6):
        blocks = (Block(4.0, c=0.02), *_DAMPED)
        jordan = _matrices(blocks)
        jordan["K"][0, 1] += coupling
        row = f"a Jordan block, coupling {coupling:.0e}"
        yield _run(row, blocks, jordan, expected="warned")


def _rounding() -> Runs:
    symmetric = tuple(Block(block.k, block.c) for block in _DAMPED)
    for row, blocks in (
        ("unsymmetric by friction and by rounding", _DAMPED),
        ("symmetric but for rounding", symmetric),
    ):
        rounded = _transformed(_matrices(blocks), _MIXED)
        rounded["K"] = rounded["K"] * (1 + 2e-16 * np.sign(np.tri(_N) - 0.5))
        yield _run(row, blocks, rounded)


def matrices_from_files() -> Runs:
    """Matrices from files: units, tiny and singular masses, multiple eigenvalues, rounding."""
    for part in (_units, _masses, _clusters, _rounding):
        yield from part()


def graded() -> Runs:
    """Badly scaled matrices: graded unknowns and equations."""
    random = np.random.default_rng(11)
    turn: Floats = qr(random.standard_normal((_N, _N)))[0]
    steps = [random.permutation(np.linspace(-1.0, 1.0, _N)) for _ in range(2)]
    for name, blocks in (("undamped", _UNDAMPED), ("damped, rotating", _DAMPED)):
        plain = _transformed(_matrices(blocks), turn.T) | {"M": np.eye(_N)}
        for digits in (2, 4, 6, 9, 12):
            # Scaling rows and columns changes no eigenvalue; powers of two round nothing.
            one, other = (2.0 ** np.round(digits * np.log2(10.0) * each) for each in steps)
            for words, right in (("D K D^-1", 1 / one), ("D1 K D2", other)):
                scaled = {key: one[:, None] * matrix * right for key, matrix in plain.items()}
                yield _run(f"{words}, {name}, 1e-{digits} to 1e{digits}", blocks, scaled)
    half, shear = _N // 2, np.zeros((_N, _N))
    shear[:half, half:] = turn[:half, half:]
    for size in (1e1, 1e3, 1e5, 1e7):  # a similarity that no scaling undoes
        there, back = np.eye(_N) + size * shear, np.eye(_N) - size * shear
        K = turn.T @ (there @ _matrices(_UNDAMPED)["K"] @ back) @ turn
        sheared = {"M": np.eye(_N), "K": K}
        yield _run(f"sheared by {size:.0e}, turned", _UNDAMPED, sheared, expected="honest")


def exceptional_point() -> Runs:
    """Hoffmann's model at 1e-2 to 1e-14 from its coalescence."""
    # Beyond mu_c (1 + d) it grows by about sqrt(d); below it does not grow.
    k11, k12, k22, k3 = 2.5, 0.5, 2.0, 4 / 3
    critical = ((k11 - k22) ** 2 + 4 * k12**2) / (4 * k12 * k3)
    others = np.linspace(0.6, 4.0, 6)  # kappa of unknowns that are coupled to nothing
    for side, word in ((1.0, "beyond"), (-1.0, "before")):
        for distance in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14):
            # kappa = 2.25 -+ sqrt(-d (k11 - k22)^2 / 4 - d k12^2)
            split = -side * distance * ((k11 - k22) ** 2 / 4 + k12**2)
            root, middle = np.sqrt(complex(split)), 0.5 * (k11 + k22)
            true = lambdas(np.array([middle - root, middle + root, *others]))
            K = block_diag([[k11, k12], [k12, k22]], np.diag(others))
            K[0, 1] -= critical * (1 + side * distance) * k3
            expected, row = "accurate" if distance > 1e-6 else "warned", f"{distance:.0e}"
            matrices = {"M": np.eye(len(K)), "K": K}
            yield _run(f"{word} it by {row}", true, matrices, expected=expected, lowest=7)


def multiplicities() -> Runs:
    """Eigenvalues of multiplicity 2 to 30 in given matrices."""
    beyond = np.linspace(20.0, 1e4, 60)  # kappa beyond the window
    for number in (2, 5, 13, 30):
        for word, mu in {"stable": 0.0, "fluttering": 0.3, "diverging": 2.0}.items():
            block = np.array([[1.0, -mu], [mu if word == "fluttering" else -mu, 1.1]])
            kappas = np.linalg.eigvals(block)
            K = block_diag(*[block] * number, np.diag(beyond))
            turn: Floats = qr(np.random.default_rng(1).standard_normal(K.shape))[0]
            true = lambdas(np.concatenate([np.repeat(kappas, number), beyond]))
            turned = {"M": np.eye(len(K))} | _transformed({"K": K}, turn)
            yield _run(f"{number} copies, {word}", true, turned, lowest=2 * number)


_CPE8R, _MIDDLE = [0, 6, 8, 2, 3, 7, 5, 1], 4
"""Nodes of a quadratic cell in the order of Abaqus' CPE8R, and its middle node."""


@dataclass(frozen=True)
class OfMeshFile:
    """A scene of rectangles of quadratic cells, written to a deck of Abaqus and read from it."""

    data: Mapping[str, Any]
    unit: Unit = "m"  # of lengths in the deck
    step: int = 1  # between the numbers of nodes
    geometry: Mapping[str, Any] = field(default_factory=dict)  # fields of every body that differ
    notched: str = ""  # a body without the cells beyond the origin along both axes

    def solve(self, max_frequency: float | None) -> Answer | StressAnswer:
        """Write, read, and solve."""
        data, text, first = deepcopy(dict(self.data)), "", 1
        places = [pair[side] for pair in data["contacts"].values() for side in ("a", "b")]
        with TemporaryDirectory() as folder:
            deck = Path(folder) / "bodies.inp"
            for name, each in data["bodies"].items():
                faces = {place.split(".")[1] for place in places if place.startswith(f"{name}.")}
                faces |= {support["surface"] for support in each["supports"]}
                given = each["geometry"]
                shape = Rectangle(tuple(given["size"]), tuple(given["origin"]))
                breaks = breaks_of(shape, each["mesh"]["fe"]["elements"])
                mesh = shape_mesh(shape, "quadrilateral", 2, breaks=breaks)
                text += self._part(name, mesh, faces, first)
                first += len(mesh.points)
                sets = {"part": name, "faces": {face: f"{name}_{face}" for face in faces}}
                file = {"shape": "mesh_file", "file": str(deck), "unit": self.unit}
                each |= {"geometry": {**file, **sets, **self.geometry}, "mesh": {}}
            deck.write_text(text)
            return OfScene(data).solve(max_frequency)

    def _part(self, name: str, mesh: Mesh, faces: set[str], first: int) -> str:
        """Nodes, elements and sets of nodes of a body, numbered from a first number."""
        cells, points = mesh.cells, mesh.points
        if name == self.notched:
            cells = cells[points[cells[:, _MIDDLE]].min(axis=1) < 0]
        cells = cells[:, _CPE8R]
        used, numbers = np.unique(cells), self.step * (first + np.arange(len(points)))
        above, below = METRES[self.unit]
        at = zip(numbers[used], (points[used] * below / above).tolist(), strict=True)
        lines = ["*NODE", *(f"{number}, {x!r}, {y!r}" for number, (x, y) in at)]
        elements = enumerate(numbers[cells].tolist(), first)
        lines += [f"*ELEMENT, TYPE=CPE8R, ELSET={name}"]
        lines += [", ".join(map(str, [number, *nodes])) for number, nodes in elements]
        sets = {"corner": np.flatnonzero(points.min(axis=1) == 0), **mesh.surfaces}
        for face in faces:
            on = np.intersect1d(sets[face], used)
            lines += [f"*NSET, NSET={name}_{face}", *map(str, numbers[on])]
        return "\n".join([*lines, ""])


def mesh_files() -> Runs:
    """Bodies from mesh files."""
    ways = chosen(PAIR, backend="fe")
    for row, data, problem in (
        ("metres", layers(), OfMeshFile),
        ("micrometres", layers(), partial(OfMeshFile, unit="um")),
        ("feet", layers(), partial(OfMeshFile, unit="ft")),
        ("elements of aspect 1e4", layers(height=1e-4), OfMeshFile),
        ("node numbers to 1e9", layers(), partial(OfMeshFile, step=10**7)),
        ("a pad that ends on its base", pad(), partial(OfMeshFile, unit="mm")),
    ):
        yield from runs(row, data, ways, problem=problem)
    for row, name, value in (
        ("no unit", "unit", None),
        ("two bodies as one", "part", None),
        ("a set that is not there", "faces", {"y_min": "nowhere"}),
    ):
        wrong = partial(OfMeshFile, geometry={name: value})
        data = layers()
        yield from runs(row, data, ways, None, expected="refused", problem=wrong, names=name)


def _corner(p: float, *, together: bool = True, E: float = 1.0) -> Scene:
    """A block in the corner of a seat, one contact over both faces or one for each."""
    block = patch([[0.0, 0.0], [1.0, 0.0]], [[0.0, 1.0], [1.0, 1.0]])
    below, left = [[0, 1, 0]], [[0, 0, 0]]
    block["faces"] = {"below": below, "left": left, "corner": below + left}
    seat = patch([[-0.5, -0.5], [0.0, -0.5]], [[-0.5, 0.0], [0.0, 0.0]])
    for low, high in (((0.0, -0.5), (1.5, 0.0)), ((-0.5, 0.0), (0.0, 1.5))):
        part = patch([[low[0], low[1]], [high[0], low[1]]], [[low[0], high[1]], [high[0], high[1]]])
        seat["patches"] += part["patches"]
    floor, wall, foot = [[1, 1, 1]], [[2, 0, 1]], [[0, 1, 0], [1, 1, 0]]
    seat["faces"] = {"base": foot, "floor": floor, "wall": wall, "corner": floor + wall}
    bodies = {
        "block": body(block, (4, 4), E=E),
        "seat": body(seat, (3, 3), E=E, held="base"),
    }
    if together:
        return scene(bodies, contact=_push("block.corner", "seat.corner", [1.0, 1.0], p))
    return scene(
        bodies,
        floor=_push("block.below", "seat.floor", [1.0, 0.0], p),
        wall=_push("block.left", "seat.wall", [0.0, 1.0], p),
    )


def _push(a: str, b: str, direction: list[float], p: float) -> Scene:
    return contact(a, b, p=p, friction_direction_on_a={"vector": direction})


def contact_corner() -> Runs:
    """A contact whose surfaces turn a corner."""
    rigid, mu = 1e7, 0.3  # E beside a contact of p = 1 N/m³
    bodies = {
        "block": body(rectangle((1.0, 1.0)), (4, 4), E=rigid),
        "seat": body(rectangle((2.0, 2.0), (-0.5, -0.5)), (8, 8), E=rigid, held="y_min"),
    }
    of_file = scene(bodies, contact=_push("block.corner", "seat.corner", [1.0, 1.0], 1.0))
    # Motions of a rigid block along x, along y and about the corner: on a face the gap is n.u, the
    # slip k.u, and its pressure and friction are p (n - mu k) n.u (k the direction of friction).
    K = [[1.0, mu, (mu - 1) / 2], [mu, 1.0, (1 - mu) / 2], [-0.5, 0.5, 2 / 3]]
    M = [[1.0, 0.0, -0.5], [0.0, 1.0, 0.5], [-0.5, 0.5, 2 / 3]]
    true = formula(lambdas(eigvals(K, M)).tolist())
    ways = chosen(WAYS, "segments", "mortar", "GPTS, penalty", "GPTS, saddle")
    file, seat = chosen(ways, backend="fe"), partial(OfMeshFile, notched="seat")
    yield from runs("rigid bodies", up_to(1.0, of_file), file, true, problem=seat, tolerance=1e-6)
    data, iga = up_to(1.0, _corner(1.0, E=rigid)), chosen(ways, backend="iga")
    yield from runs("rigid bodies", data, iga, true, tolerance=1e-6)
    for row, p, some in (
        ("as a contact for each face", 1.0, chosen(WAYS, backend="iga")),
        ("tied, as a tie for each face", inf, chosen(SADDLE, "mortar", backend="iga")),
    ):
        yield from runs(row, _corner(p), some, instead=_corner(p, together=False))
