"""At which friction does a brake begin to squeal? Sweep mu, find the threshold, plot both."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from scenes import AssembledScene, assemble, load_scene

MU = "contacts.pad_disc.mu"
SCENE = load_scene("disc_pad").change(  # put the path of your own scene here
    {
        "bodies.pad.mesh.iga.elements": [3, 5, 1],
        "bodies.disc.mesh.iga.elements": [6, 28, 1],
        "analysis.max_frequency": 7000.0,
    }
)


def sweep(assembled: AssembledScene, frictions: np.ndarray) -> list[float]:
    """Return the largest growth rate (1/s) at each friction, without assembling again."""
    return [float(assembled.modes(mu=mu).growth_rates.max()) for mu in frictions.tolist()]


def draw(frictions: np.ndarray, growth: list[float], threshold: float, file: Path) -> None:
    """Plot growth against friction, with the threshold."""
    axes = (figure := Figure(layout="constrained")).subplots()
    axes.plot(frictions, growth, "o-")
    axes.axvline(threshold, linestyle="--", label=f"flutter from mu = {threshold:.4f} on")
    axes.set(xlabel="mu", ylabel="growth rate of the fastest mode (1/s)")
    axes.legend()
    figure.savefig(file)


if __name__ == "__main__":
    brake, frictions = assemble(SCENE), np.linspace(0.0, 0.5, 11)
    threshold = brake.threshold(MU, real=0.0, flutter=0.5)
    print(f"flutter from mu = {threshold.value:.4f} on, at {threshold.frequency:.0f} Hz")
    draw(frictions, sweep(brake, frictions), threshold.value, Path("brake_sweep.png"))
    brake.modes(mu=0.5).plot().save("fastest_mode.png")
