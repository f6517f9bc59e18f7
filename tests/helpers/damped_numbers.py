"""A damped scene with a rotating disc and a pad that slides: data, and numbers on any ranks."""

from blocks import contact, scene_body

RATE = 0.3


def damped_disc(backend, **fields):
    """A disc that rotates under a pad, both damped, with everything that acts on velocities."""
    annulus = {"shape": "annulus", "inner_radius": 0.5, "outer_radius": 1.0}
    sector = {"shape": "sector", "inner_radius": 0.6, "outer_radius": 0.9}
    disc = scene_body(
        backend,
        annulus | {"bottom": 0.0, "top": 0.2},
        [1, 8, 1],
        material={"E": 2.0, "nu": 0.3, "rho": 1.0},
        supports=[{"surface": "inner"}],
        damping={"alpha": 0.01, "beta": 0.002},
        rotation={"rate": RATE, "convective_stiffness": True},
    )
    pad = scene_body(
        backend,
        sector | {"start": 10.0, "end": 60.0, "bottom": 0.2, "top": 0.4},
        [1, 2, 1],
        material={"E": 1.0, "nu": 0.3, "rho": 1.0},
        supports=[{"surface": "top"}],
        damping={"ratios": [0.01, 0.02], "frequencies": [0.1, 0.4]},
    )
    around = {"circumferential_about": [0.0, 0.0, 1.0]}
    sliding = {"pressure": 0.02, "speed": f"{RATE}*r", "mu_slope": -0.1}
    interface = contact("pad.bottom", "disc.top", 3, around, mu=0.4, p=5.0, sliding=sliding)
    return {
        "name": "damped disc",
        "bodies": {"pad": pad, "disc": disc},
        "contacts": {"interface": interface | fields},
        "analysis": {"kind": "cea", "max_frequency": 0.3},
    }


def modally_damped_disc(backend, **fields):
    """The same with modal damping: one ratio of the disc, a table of the pad beside Rayleigh's."""
    data = damped_disc(backend, **fields)
    data["bodies"]["disc"]["damping"] = {"modal": {"ratio": 0.02, "max_frequency": 0.45}}
    table = {"ratios": [0.01, 0.0, 0.03], "frequencies": [0.1, 0.3, 0.5]}
    data["bodies"]["pad"]["damping"]["modal"] = table
    return data
