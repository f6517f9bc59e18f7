"""Largest growth rate of disc and pad with several contact formulations.

Bodies are built once; only contact is assembled for each formulation.
"""

from scenes import load_scene, run_modes

FORMULATIONS = {
    "collocation": {"method": "greville"},
    "GPTS": {"method": "gpts", "points": 4},
    "GPTS, lumped": {"method": "gpts", "points": 4, "lumped": True},
    "segments": {"method": "segments"},
    "mortar": {"method": "mortar"},
}
COARSE = {
    "bodies.pad.mesh.iga.elements": [3, 5, 1],
    "bodies.disc.mesh.iga.elements": [6, 28, 1],
    "analysis.max_frequency": 8500.0,
}


def largest_growth_rates() -> dict[str, float]:
    """Return the largest growth rate (1/s) by formulation."""
    scene, bodies, found = load_scene("disc_pad").change(COARSE), None, {}
    for name, formulation in FORMULATIONS.items():
        changed = scene.change("contacts.pad_disc.formulation", formulation)
        result = run_modes(changed, bodies=bodies)
        bodies = result.bodies
        found[name] = float(result.growth_rates.max())
    return found


if __name__ == "__main__":
    for name, growth in largest_growth_rates().items():
        print(f"{name:14} {growth:8.2f} 1/s")
