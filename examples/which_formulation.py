"""Compare formulations with mortar, which neither locks nor loses digits, at several p."""

from scenes import assemble, load_scene

CONTACT = "contacts.pad_disc"
SCENE = load_scene("disc_pad").change(  # put the path of your own scene here
    {
        "bodies.pad.mesh.iga.elements": [3, 5, 1],
        "bodies.disc.mesh.iga.elements": [6, 28, 1],
        "analysis.max_frequency": 8500.0,
    }
)
FORMULATIONS = {
    "greville": {"method": "greville"},
    "gpts, 3 points": {"method": "gpts", "points": 3},
    "gpts, 5 points": {"method": "gpts", "points": 5},
    "gpts, lumped": {"method": "gpts", "points": 5, "lumped": True},
    "segments": {"method": "segments"},
}


def growth_rates(p: float) -> dict[str, float]:
    """Return the largest growth rate (1/s) by formulation, for a contact stiffness p (N/m^3)."""
    stiffness = {f"{CONTACT}.P": None, f"{CONTACT}.p": p}
    mortar = {f"{CONTACT}.formulation": {"method": "mortar"}, f"{CONTACT}.form": "saddle"}
    assembled = assemble(SCENE.change(stiffness | mortar))  # bodies are built once
    found = {"mortar": float(assembled.modes().growth_rates.max())}
    for name, formulation in FORMULATIONS.items():
        changes = {f"{CONTACT}.formulation": formulation, f"{CONTACT}.form": None}
        found[name] = float(assembled.modes(changes).growth_rates.max())
    return found


if __name__ == "__main__":
    for p in (3e10, 1e11, 3e11):
        found = growth_rates(p)
        print(f"p = {p:.0e} N/m^3")
        for name, growth in found.items():
            print(f"{name:>18}{growth:9.1f} 1/s, off by {growth - found['mortar']:+.1f}")
