"""Materials of several constants: closed forms, changes of frame, isotropic solids."""

import numpy as np
import pytest
from blocks import alone, scene_body

from cea.material import Axes, OrthotropicMaterial
from scenes import assemble, load_scene, read_scene, run_modes
from scenes.building.build import build_body

WOOD = {
    "kind": "orthotropic",
    **{"E_1": 1.6e10, "E_2": 1.1e9, "E_3": 6e8, "nu_12": 0.37, "nu_13": 0.43, "nu_23": 0.47},
    **{"G_12": 1.2e9, "G_13": 9e8, "G_23": 2e8, "rho": 700.0},
}
FIVE = {
    "kind": "orthotropic",
    **{"E_1": 1e10, "E_3": 3e9, "nu_12": 0.3, "nu_13": 0.2, "G_13": 1.5e9, "rho": 2500.0},
}
OBLIQUE = {"first": [1.0, 2.0, 0.5], "second": [0.0, 1.0, 1.0]}
ROUND = {"cylindrical_about": [0.0, 0.0, 1.0]}
SIZE = (0.05, 0.03, 0.02)
ENDS = ({"surface": "x_min"},)


def block(backend, material, elements=(3, 2, 2), supports=ENDS, top=40000.0, **sections):
    """A box of one material, held at one end unless told otherwise."""
    geometry = {"shape": "box", "size": SIZE}
    sections |= {"material": material, "supports": list(supports)}
    return read_scene(alone(scene_body(backend, geometry, list(elements), **sections), top))


def lowest(scene, count=6):
    return np.sort(run_modes(scene).frequencies)[:count]


def isotropic(E, nu, rho):
    constants = {f"E_{i}": E for i in "123"} | {"rho": rho}
    for ij in ("12", "13", "23"):
        constants |= {f"nu_{ij}": nu, f"G_{ij}": E / (2 * (1 + nu))}
    return {"kind": "orthotropic"} | constants


@pytest.mark.grid
@pytest.mark.parametrize("axes", [None, {"cylindrical_about": [0, 0, 1], "origin": [-3, -2, 0]}])
def test_isotropic_constants_give_the_isotropic_eigenvalues(backend, axes):
    """In the plane, with contact, and in space."""
    solid = block(backend, {"E": 1e10, "nu": 0.3, "rho": 2500.0}, (2, 2, 1), top=20000.0)
    few = {f"bodies.{name}.mesh.{backend}.elements": [5, 2] for name in ("upper", "lower")}
    plane = load_scene("blocks", backend=backend).change(few)
    for scene, name in ((plane, "upper"), (solid, "part")):
        own = scene.bodies[name].material
        other = isotropic(own.E, own.nu, own.rho) | {"axes": axes}
        found = run_modes(scene.change(f"bodies.{name}.material", other)).eigenvalues
        right = run_modes(scene).eigenvalues
        assert np.abs(found - right).max() <= 1e-12 * np.abs(right).max()


def rotated(material):
    """The same solid by its constants in the axes of space."""
    solid = OrthotropicMaterial(**{k: v for k, v in material.items() if k != "axes"})
    R = Axes(**material["axes"]).at(np.zeros((3, 1)))[:, :, 0]
    place = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    tensor = solid.elasticity.matrix[place][..., place]
    tensor = np.einsum("ip,jq,kr,ms,pqrs->ijkm", R, R, R, R, tensor)
    i, j = [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]
    matrix = tensor[i, j][:, i, j]
    entries = {f"C_{a + 1}{b + 1}": float(matrix[a, b]) for a in range(6) for b in range(a, 6)}
    return {"kind": "anisotropic", "C": entries, "rho": material["rho"]}


def test_turned_axes_are_the_turned_tensor_and_a_turned_block_is_the_same(backend):
    """Change of frame: nothing tells the block from one that lies elsewhere in space."""
    turned = WOOD | {"axes": OBLIQUE}
    found = lowest(block(backend, turned))
    assert found == pytest.approx(lowest(block(backend, rotated(turned))), rel=1e-12)
    scene = block(backend, turned, placement={"axis": [1.0, 2.0, 3.0], "angle": 40.0})
    turn = scene.bodies["part"].placement.rotation
    axes = {name: (turn @ vector).tolist() for name, vector in OBLIQUE.items()}
    there = lowest(scene.change("bodies.part.material.axes", axes))
    assert there == pytest.approx(found, rel=1e-10)


PLANE_WAVES = {
    "z": ((2, 2), {"x": ["x"], "y": ["y"]}),
    "x": ((4, 4), {"x": ["z"], "y": ["y", "z"]}),
    "y": ((3, 3), {"x": ["x", "z"], "y": ["z"]}),
}
"""By displacement: the constant, and what sides hold so that a plane wave along z is exact."""


@pytest.mark.grid
@pytest.mark.parametrize("moving", PLANE_WAVES)
def test_plane_waves_have_the_speeds_of_the_closed_form(backend, moving):
    constant, held = PLANE_WAVES[moving]
    supports = [
        {"surface": f"{side}_{end}", "components": components}
        for side, components in held.items()
        for end in ("min", "max")
    ]
    C = OrthotropicMaterial(**WOOD).elasticity.matrix
    right = np.sqrt(C[constant] / WOOD["rho"]) / (2 * SIZE[2])
    errors = []
    for elements in (4, 8):
        found = run_modes(block(backend, WOOD, (1, 1, elements), supports, 250000.0)).frequencies
        errors.append(np.abs(found / right - 1).min())
    assert errors[1] < 3e-5
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.1)


@pytest.mark.slow
def test_both_backends_converge_to_the_same_disc_with_cylindrical_axes():
    geometry = {"shape": "annulus", "inner_radius": 0.1, "outer_radius": 0.2}
    geometry |= {"bottom": 0.0, "top": 0.03}
    material, apart = WOOD | {"axes": ROUND}, []
    for n in (1, 2):
        found = {}
        for backend, around in (("fe", 24), ("iga", 12)):
            disc = scene_body(backend, geometry, [3 * n, around * n, n], material=material)
            found[backend] = lowest(read_scene(alone(disc, 3000.0)), 12)[6:]  # others are rigid
        apart.append(np.abs(found["fe"] / found["iga"] - 1).max())
    assert apart[1] < 3e-3
    assert apart[1] < apart[0] / 12


@pytest.mark.grid
@pytest.mark.parametrize("material", [WOOD | {"axes": OBLIQUE}, FIVE], ids=["nine", "five"])
def test_modes_and_derivatives_in_constants_are_those_of_other_scenes(backend, material):
    """The pencil at other constants against a fresh scene; derivatives against differences."""
    scene = block(backend, material, (1, 1, 1), damping={"alpha": 5.0, "beta": 1e-8})
    assembled = assemble(scene)
    modes = assembled.modes(left=True).modes
    names = [name for name in material if name[0] in "EnG"]
    for name in names[:: len(names) // 4]:
        path, step = f"bodies.part.material.{name}", 1e-4 * material[name]
        above, below = (
            run_modes(scene.change(path, material[name] + sign * step)).eigenvalues[0]
            for sign in (1, -1)
        )
        there = assembled.modes({path: material[name] + step}).eigenvalues[0]
        assert abs(there - above) <= 1e-11 * abs(there)
        slope = (above - below) / (2 * step)
        assert modes.sensitivity(path)[0] == pytest.approx(slope, rel=1e-4)


def test_energy_of_a_uniform_strain_and_its_stresses(backend):
    """u^T K u = V eps : C : eps, and v^T K_g v = V sigma : (grad v)^T grad v, for linear u, v."""
    scene = block(backend, WOOD | {"axes": OBLIQUE}, (1, 1, 1), supports=[])
    body = build_body("part", scene.bodies["part"])
    space, elasticity = body.space, body.material.elasticity
    x = space.dof_positions
    u, v = (np.random.default_rng(seed).normal(size=(3, 3)) for seed in (1, 2))
    stress = elasticity.stress(u[..., None], np.zeros((3, 1)))[..., 0]
    moved = (x @ u.T).ravel()
    for matrix, vector, right in (
        (space.stiffness(elasticity), moved, stress * u),
        (space.geometric_stiffness(elasticity, moved), (x @ v.T).ravel(), stress * (v.T @ v)),
    ):
        left, product = matrix.createVecs()
        left.setArray(vector)
        matrix.mult(left, product)
        assert left.dot(product) == pytest.approx(np.prod(SIZE) * np.sum(right), rel=1e-11)


def test_cylindrical_axes_are_those_of_expressions():
    x = np.random.default_rng(3).normal(size=(3, 20))
    given = Axes(("x/r", "y/r", 0.0), ("-y/r", "x/r", 0.0)).at(x)
    assert given == pytest.approx(Axes(cylindrical_about=(0.0, 0.0, 2.0)).at(x), abs=1e-15)
