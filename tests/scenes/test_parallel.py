"""The same answers on 1, 2 and 3 ranks, and one voice whatever goes wrong."""

import json
import sys
from contextlib import suppress
from functools import partial
from time import monotonic
from unittest.mock import Mock, patch

import numpy as np
import pytest
from bad_inputs import coarse
from blocks import alone, block, two_blocks
from blocks import coarse as of_few_elements
from motions import asymmetry
from mpi import cea_on_ranks, on_ranks
from same_numbers import assert_same

from cea.eigen.krylov_schur import KrylovOptions
from cea.petsc import MPI
from comparisons.cli import app
from comparisons.study.matching import match_spectrum
from scenes import run_modes, run_scene
from scenes.running import run
from scenes.spec.plain import checked
from scenes.spec.reading import Scene, read_scene

pytestmark = pytest.mark.mpi
slow = pytest.mark.slow
in_krylov_spaces = patch("cea.eigen.driver.KrylovOptions", lambda: KrylovOptions(dense_limit=0))
"""Small systems are searched like large ones, which ranks share: LAPACK would solve them whole."""
GRID, GPTS = {"method": "grid", "points": 5}, {"method": "gpts", "points": 4}
ONE_POINT = {"method": "gpts", "points": 1}


FORMULATIONS = {
    "collocation": {},
    "gpts": {"formulation": GPTS},
    "lumped": {"formulation": GPTS | {"lumped": True}},
    "full pass": {"formulation": GPTS, "full_pass": True},
    "segments": {"formulation": {"method": "segments"}},
    "mortar": {"formulation": {"method": "mortar"}},
    "tied mortar": {"formulation": {"method": "mortar"}, "form": "saddle", "P": float("inf")},
}
"""What each changes in a contact of collocation."""


def blocks(backend, contact="gpts", mu=1.0):
    """Two blocks that flutter, and few modes: each takes messages, slow where ranks share cores."""
    collocation = {"method": {"fe": "node_to_surface", "iga": "greville"}[backend]}
    data = of_few_elements(two_blocks(backend, collocation, held=True, mu=mu, P=30.0))
    data["contacts"]["interface"] |= FORMULATIONS[contact]
    return data | {"analysis": {"kind": "cea", "max_frequency": 0.55, "growth_threshold": 1e-3}}


def static_blocks(backend):
    loads = [{"surface": "upper.x_min", "pressure": 0.02}]
    analysis = {"kind": "static", "samples": 7}
    return blocks(backend) | {"analysis": analysis, "loads": loads}


def overhanging(backend):
    data = blocks(backend)
    data["bodies"]["upper"]["geometry"]["origin"][0] = 0.75
    data["contacts"]["interface"]["max_missed"] = 0.6
    return data


def single_point(backend):
    """Fewer contact points than ranks."""
    data = static_blocks(backend)
    data["contacts"]["interface"]["formulation"] = ONE_POINT
    for mesh in data["bodies"]["upper"]["mesh"].values():
        mesh["elements"] = [1, 1, 1]
    return data


def column(backend):
    """Square column, whose bending modes come in pairs of one frequency."""
    body = block(backend, [1.0, 1.0, 2.0], [0, 0, 0], [2, 2, 3], supports=[{"surface": "z_min"}])
    return alone(body, 0.3)


def mixed_pairing(backend):
    data = blocks(backend)
    data["bodies"]["lower"]["backend"] = {"fe": "iga", "iga": "fe"}[backend]
    return data


def disc_pad(backend):
    """Disc and pad on few elements, on which the modes flutter late."""
    data = coarse("disc_pad", backend, {"pad": [2, 3, 1], "disc": [2, 16, 1]})
    method = {"fe": GRID, "iga": {"method": "segments"}}[backend]
    data["contacts"]["pad_disc"] |= {"formulation": method, "mu": 2.0}
    data["analysis"]["max_frequency"] = 6000.0
    return data


def saddle():
    """Eigenvalues and derivatives where some ranks have contact forces and no displacements.

    In the second scene each constraint is there once more, in another contact.
    """
    few = blocks("fe", mu=0.3) | {"analysis": {"kind": "cea", "max_frequency": 1.0}}
    for body in few["bodies"].values():
        body["mesh"]["fe"] |= {"elements": [1, 1, 1], "degree": 1}
    few["contacts"]["interface"] |= {"formulation": ONE_POINT, "form": "saddle"}
    twice = blocks("iga", "tied mortar", mu=0.3)
    twice["contacts"]["again"] = twice["contacts"]["interface"]
    modes = run_modes(read_scene(few), left=True).modes
    return {
        "im": modes.eigenvalues.imag.tolist(),
        "slopes": np.abs(modes.sensitivity("contacts.interface.mu")).tolist(),
        "tied twice": run_modes(checked(Scene, twice)).modes.eigenvalues.imag.tolist(),
    }


KINDS = {
    **{name: partial(blocks, contact=name) for name in FORMULATIONS},
    "static": static_blocks,
    "without friction": partial(blocks, mu=0.0),
    "overhanging": overhanging,
    "single point": single_point,
    "column": column,
    "disc and pad": disc_pad,
    "several discs": lambda backend: two_blocks(backend, GRID, held=True, mu=2.0),
    "on the other backend": mixed_pairing,
}
SEARCHED = ("several discs", "gpts", "column")
"""Cases that are searched in Krylov spaces."""


def probes(result):
    """Trace of each box at fixed points of its side x_max."""
    traces = {}
    for name, body in result.system.bodies.items():
        spec = result.scene.bodies[name].geometry
        if spec.shape != "box":
            continue
        inner = np.array([[1.0, y, z] for y in (0.13, 0.57) for z in (0.21, 0.83)])
        x = np.array(spec.origin) + inner * np.array(spec.size)
        found = body.surfaces["x_max"].locate(x, np.tile([1.0, 0.0, 0.0], (len(x), 1)), 1e-3)
        assert not found.missed.any()
        traces[name] = body.surfaces["x_max"].trace(found.at)
    return traces


def facts(scene):
    result = run_scene(scene)
    system, data = result.system, dict(result.data)
    matrices = [system.pencil().at().stiffness]
    matrices += [contact.K_n for contact in system.contacts if contact.has_pressure]
    matrices += [body.stiffness() for body in system.bodies.values()]
    matrices += [body.mass() for body in system.bodies.values() if system.with_mass]
    shown = {name: data.get(name) for name in ("contacts", "dofs", "stresses", "skipped")}
    shown["asymmetry"] = [asymmetry(matrix) for matrix in matrices]
    if result.spectrum is None:
        moved = [result.displacements(name, at).tolist() for name, at in probes(result).items()]
        return shown | {"displacements": moved}
    modes = result.modes
    shapes = [result.mode_shapes(name, trace) for name, trace in probes(result).items()]
    return shown | {
        "re": modes.growth_rates.tolist(),
        "im": modes.eigenvalues.imag.tolist(),
        "worst_residual": modes.residuals.max(),
        "count": [modes.window.found_below, modes.window.discs],
        "unstable": len(data["unstable"]),
        "shapes": np.moveaxis(np.abs(np.concatenate(shapes)), 2, 0).tolist() if shapes else [],
    }


def case(backend, kind):
    """Facts of a case."""
    scene = read_scene(KINDS[kind](backend))
    return (in_krylov_spaces(facts) if kind in SEARCHED else facts)(scene)


def cases():
    """Each kind on each backend and number of ranks; the quick tests run each once."""
    for ranks in (2, 3):
        for i, kind in enumerate(KINDS):
            for j, backend in enumerate(("fe", "iga")):
                quick = (i + j) % 2 == 0 and ranks == (3 if i % 6 == 0 else 2)
                yield pytest.param(ranks, backend, kind, marks=() if quick else slow)


def assert_same_eigenvalues(found, expected):
    """Equal to 1e-9 as sets; of a near-coalescence only the mean of the pair is well conditioned.

    lambda = +-w + i w' near a coalescence: rounding e of kappa moves the members by sqrt(e), their
    mean by e.
    """
    left, right = (np.array(v["re"]) + 1j * np.array(v["im"]) for v in (found, expected))
    match = match_spectrum(left, right, tolerance=1e-3)
    assert len(match.missing) == len(match.spurious) == 0
    assert match.errors.max() < 1e-9


@pytest.mark.parametrize(("ranks", "backend", "kind"), [*cases()])
def test_answers_do_not_depend_on_the_number_of_ranks(ranks, backend, kind):
    found, expected = (dict(on_ranks(n, case, backend, kind)) for n in (ranks, 1))
    asymmetry = found.pop("asymmetry")
    assert asymmetry == expected.pop("asymmetry") == [0.0] * len(asymmetry)
    if "im" in expected:
        assert len(expected["im"]) >= 3
        assert kind != "disc and pad" or max(expected["re"]) > 100
        worst = 1e-9 if kind == "disc and pad" else 1e-7
        assert found.pop("worst_residual") < worst > expected.pop("worst_residual")
        assert_same_eigenvalues(found, expected)
        shapes, expected_shapes = found.pop("shapes"), expected.pop("shapes")
        if kind != "column":  # copies of one frequency have no shape of their own
            largest = np.max(shapes, initial=0.0)
            np.testing.assert_allclose(shapes, expected_shapes, atol=1e-6 * largest)
        for part in ("re", "im"):
            found.pop(part)
            expected.pop(part)
    assert_same(found, expected)


@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=slow)])
def test_forces_on_ranks_without_displacements(ranks):
    found, expected = (on_ranks(n, saddle) for n in (ranks, 1))
    assert len(found["im"]) > 3
    for name, values in expected.items():
        assert sorted(found[name]) == pytest.approx(sorted(values), rel=1e-9, abs=1e-12)


def test_command_line_prints_and_writes_once(tmp_path):
    command, found = ["run", "patch_test", "--set", "output.paraview=1"], []
    for setting in ("contacts.interface.formulation.points=3", "analysis.samples=4"):
        command += ["--set", setting]
    for ranks in (2, 1):
        out = tmp_path / str(ranks)
        done = cea_on_ranks(ranks, *command, "--out", out)
        assert done.returncode == 0, done.stderr
        assert done.stdout.count("result.json") == done.stdout.count("side b") == 1
        written = {path.name for path in out.glob("*") if path.is_file()} - {"contacts.pvd"}
        assert written == {"manifest.json", "result.json", "displacement.pvd"}
        found.append(json.loads((out / "result.json").read_text()))
    assert found[0].keys() == found[1].keys()
    for part in ("stresses", "contacts"):
        assert_same(found[0][part], found[1][part])


HELD = [
    word
    for body in ("upper", "lower")
    for field in (
        "mesh.fe={cell='quadrilateral', degree=1, elements=[1, 1]}",
        "supports=[{surface='x_min'}, {surface='x_max'}]",
    )
    for word in ("--set", f"bodies.{body}.{field}")
]
"""Settings that leave no degree of freedom."""


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["patch_test", "--set", "analysis.foo=3"], "error: analysis.foo = "),
        (["patch_test", "--set", "contacts.interface.a=upper.x_min"], "error: contacts.interface"),
        (["blocks", "--backend", "fe", *HELD], "error: bodies.upper.supports = "),
    ],
)
def test_faults_of_all_ranks_are_told_once(arguments, told, tmp_path):
    done = cea_on_ranks(2, "run", *arguments, "--out", tmp_path)
    assert done.returncode not in (0, None)
    assert done.stderr.count(told) == 1
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "result.json").exists()


def lone_fault(faulty, out):
    """A command of which one rank fails; whether it ends the others is up to the program."""
    sys.argv = ["cea", "run", "patch_test", "--backend", "iga", "--out", out]
    if MPI.COMM_WORLD.rank == faulty:
        fault = RuntimeError("only one rank")
        run.build_contacts = Mock(side_effect=fault)
    with suppress(BaseException), patch.object(app, "_PATIENCE", 0.5):
        app.main()


@pytest.mark.parametrize("rank", [pytest.param(0, marks=slow), 1])
def test_a_fault_of_one_rank_ends_all(rank, tmp_path):
    """The last test here: it ends the program whose ranks the others share."""
    start = monotonic()
    with pytest.raises(AssertionError, match="ended its ranks") as ended:
        on_ranks(2, lone_fault, rank, str(tmp_path))
    assert str(ended.value).count("RuntimeError: only one rank") == 1
    assert not (tmp_path / "result.json").exists()
    assert monotonic() - start < 30
