"""Decks of CalculiX: read back as bodies, and run."""

import numpy as np
import pytest
from bodies import lagrange_body
from decks import ELEMENTS, P2, alone, body, in_contact, with_calculix

from comparisons.bench import calculix
from scenes import read_scene, run_modes
from scenes.building.build import body_mesh
from scenes.export.calculix import write_deck
from scenes.spec.problems import SceneError


def test_a_model_read_back_is_the_body_that_was_written(tmp_path):
    model = write_deck(in_contact(), tmp_path)[0]
    scene = in_contact()
    faces = {"pad": ("top", "bottom"), "disc": ("inner", "top")}
    for name, used in faces.items():
        sets = {each: f"{name}-{each}" for each in used}
        file = {"shape": "mesh_file", "file": str(model), "unit": "m", "part": name, "faces": sets}
        scene = scene.change({f"bodies.{name}.geometry": file, f"bodies.{name}.mesh": {}})
    found, before = (run_modes(each).eigenvalues for each in (scene, in_contact()))
    assert found == pytest.approx(before, abs=1e-10 * abs(before).max())


MASS = {"C3D8": None, "C3D10": 2, "C3D4": 1}
"""Degree to which CalculiX integrates the mass; None, exactly."""


def ours(scene, quadrature, top):
    """Eigenvalues of this program up to a frequency, with the mass of another."""
    scene = scene.change("analysis.max_frequency", top)
    bodies = {
        name: lagrange_body(
            name,
            body_mesh(name, spec, ()),
            degree=spec.fe_degree,
            material=spec.material,
            supports=spec.supports,
            mass_quadrature=quadrature,
        )
        for name, spec in scene.bodies.items()
    }
    return run_modes(scene, bodies=bodies).eigenvalues


LAYERED = {
    "kind": "orthotropic",
    **{"E_1": 2e11, "E_2": 4e10, "E_3": 1e10, "nu_12": 0.3, "nu_13": 0.25, "nu_23": 0.35},
    **{"G_12": 3e10, "G_13": 8e9, "G_23": 5e9, "rho": 2000.0},
}
WITHOUT_SYMMETRY = {
    "kind": "anisotropic",
    "C": {f"C_{i}{i}": 1e11 / i for i in range(1, 7)} | {"C_12": 2e10, "C_14": 9e9, "C_36": -4e9},
    "rho": 2000.0,
}
OBLIQUE = {"first": [1.0, 2.0, 0.5], "second": [0.0, 1.0, 1.0]}
ROUND_THE_AXIS = {"cylindrical_about": [0.0, 0.0, 1.0]}
SUPPORTS = {"supports": [{"surface": "inner"}, {"surface": "outer", "components": ["y"]}]}


def slow(*values):
    return pytest.param(*values, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("name", "changes", "rel"),
    [
        *((name, {}, 1e-10) for name in MASS),
        *(slow(name, SUPPORTS, 1e-8) for name in MASS),
        ("C3D10", {"material": LAYERED | {"axes": ROUND_THE_AXIS}}, 1e-6),
        slow("C3D10", {"material": LAYERED | {"axes": OBLIQUE}}, 1e-6),
        slow("C3D10", {"material": WITHOUT_SYMMETRY}, 1e-6),
    ],
)
def test_calculix_finds_the_same_frequencies(name, changes, rel, tmp_path):
    with_calculix()
    scene = alone(*ELEMENTS[name]).change({f"bodies.part.{k}": v for k, v in changes.items()})
    # The last of its list have not always converged, and one may be missing.
    found = calculix.run(write_deck(scene, tmp_path, 16)[1]).imag[:8]
    values = ours(scene, MASS[name], 1.01 * found[-1] / (2 * np.pi)).imag
    assert found == pytest.approx(np.sort(values)[:8], rel=rel)


def test_calculix_finds_the_same_flutter(tmp_path):
    """No spectrum tells the sign of friction: forces of the static step do."""
    with_calculix()
    scene = in_contact()
    deck = write_deck(scene, tmp_path, 20)[1]
    found = calculix.run(deck)
    values = ours(scene, 2, 1.01 * found.imag[-1] / (2 * np.pi))
    (theirs,) = found[found.real > 1]
    (own,) = values[values.real > 1]
    assert theirs.imag == pytest.approx(own.imag, rel=1e-5)
    assert theirs.real == pytest.approx(own.real, rel=1e-3)
    listed = deck.with_suffix(".dat").read_text().split("total surface force")[1].splitlines()
    force = np.array(listed[2].split()[:3], dtype=float)
    middle = np.array([-1.0, 1.0]) / np.sqrt(2)  # circumferential, in the middle of the pad
    size = 4 / np.radians(40) * np.sin(np.radians(20)) / 2  # of the mean direction over 40 degrees
    assert force[2] > 0  # the disc pushes the pad up
    assert force[:2] @ middle == pytest.approx(2 * 0.7 * force[2] * size, rel=0.02)


FEW = {"elements": [2, 3, 1]}
NORMAL = {"surface": "inner", "components": ["normal"]}
LINEAR_ONLY = ".degree = 2: 1, or 2 with cell = 'tetrahedron'"


@pytest.mark.parametrize(
    ("field", "value", "inside"),
    [
        ("bodies.pad.backend", "iga", ""),
        ("bodies.pad.mesh.fe", {"cell": "hexahedron", "degree": 2, **FEW}, LINEAR_ONLY),
        ("bodies.pad.mesh.fe", {**P2, "degree": 3, **FEW}, ".degree"),
        ("bodies.pad.damping", {"alpha": 1.0}, ""),
        ("bodies.disc.rotation", {"rate": 1.0}, ""),
        ("bodies.disc.supports", [NORMAL], ".0.components"),
        ("contacts.pad_disc.p", "1e11*(1+x)", ""),
        ("contacts.pad_disc.c_n", 1e12, ""),
        ("contacts.pad_disc.P", float("inf"), ""),
        ("contacts.pad_disc.full_pass", True, ""),
        ("contacts.pad_disc.sliding", {"speed": 1.0, "pressure": 1e5}, ""),
        ("contacts.pad_disc.friction_direction_on_a", {"field": ["-y", "x", "0"]}, ""),
        ("contacts.pad_disc.friction_direction_on_a", {"vector": [1.0, 0.0, 0.5]}, ""),
        ("loads", [{"surface": "disc.bottom", "pressure": 1.0}], ""),
    ],
)
def test_what_a_deck_cannot_hold_is_refused_by_its_field(field, value, inside, tmp_path):
    changes = {field: value}
    if field in ("contacts.pad_disc.p", "contacts.pad_disc.c_n"):
        changes["contacts.pad_disc.P"] = None
    with pytest.raises(ValueError, match=r"a deck|a vector, or|sides stay in contact") as error:
        write_deck(in_contact(**changes), tmp_path)
    assert field + inside in str(error.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("names", [["1part"], ["part+"], ["teil-ä"], ["part", "Part"]])
def test_names_that_programs_do_not_take_are_refused(names, tmp_path):
    data = {"name": "names", "bodies": {name: body("tetrahedron", 1) for name in names}}
    scene = read_scene({**data, "analysis": {"kind": "cea", "max_frequency": 1e4}})
    with pytest.raises(SceneError, match=r"a letter, then at most|a unique name"):
        write_deck(scene, tmp_path)
