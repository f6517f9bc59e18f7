"""Contact between a pad of Lagrange elements and a disc of NURBS."""

from scenes import load_scene, run_modes

MIXED = {
    "bodies.pad.backend": "fe",
    "bodies.pad.mesh.fe.elements": [3, 5, 1],
    "bodies.disc.backend": "iga",
    "bodies.disc.mesh.iga.elements": [6, 28, 1],
    "contacts.pad_disc.formulation": {"method": "mortar"},
    "analysis.max_frequency": 8500.0,
}


def most_unstable_frequency() -> float:
    """Return the frequency (Hz) of the mode that grows fastest."""
    result = run_modes(load_scene("disc_pad").change(MIXED))
    return float(result.frequencies[result.growth_rates.argmax()])


if __name__ == "__main__":
    print(f"{most_unstable_frequency():.1f} Hz")
