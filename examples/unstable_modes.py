"""Run a scene of the project and list its unstable modes."""

from scenes import load_scene, run_modes

COARSE = {
    "bodies.pad.mesh.iga.elements": [3, 5, 1],
    "bodies.disc.mesh.iga.elements": [6, 28, 1],
    "analysis.max_frequency": 8500.0,
}


def unstable_modes() -> list[tuple[float, float]]:
    """Return frequency (Hz) and growth rate (1/s) of each unstable mode of disc and pad."""
    result = run_modes(load_scene("disc_pad").change(COARSE))
    columns = (result.frequencies, result.growth_rates)
    return list(zip(*(column[result.unstable].tolist() for column in columns), strict=True))


if __name__ == "__main__":
    for frequency, growth in unstable_modes():
        print(f"{frequency:8.1f} Hz grows by {growth:6.1f} 1/s")
