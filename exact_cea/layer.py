"""Waves in an elastic layer: one side clamped, tractions of one harmonic on the other."""

from flint import acb, arb

from exact_cea.material import Material, Response


def layer_response(material: Material, height: arb, k: arb, kappa: acb) -> Response:
    """Response of a clamped layer to ``sigma_yy ~ cos(kx)`` and ``sigma_xy ~ sin(kx)``.

    With y the distance from the clamp, ``C = cosh``, ``S = sinh(. y) / .``,
    ``alpha^2 = k^2 + rho kappa / (L + 2G)`` and ``beta^2 = k^2 + rho kappa / G``, the solutions
    clamped at y = 0 are spanned by

        u = (k (C_b - C_a), alpha^2 S_a - k^2 S_b),   u = (beta^2 S_b - k^2 S_a, k (C_a - C_b)),

    both divided by kappa here, as they vanish with it (J. D. Achenbach, Wave Propagation in
    Elastic Solids, chapter 6).

    Parameters
    ----------
    material
        Solid of the layer.
    height
        Thickness.
    k
        Wave number along the layer; zero leaves pressure waves only.
    kappa
        Square of the eigenvalue, nonzero.
    """
    L, G = material.lame
    rho = material.rho.arb
    alpha2 = k * k + rho * kappa / (L + 2 * G)
    C_a, S_a = _hyperbolic(alpha2, height)
    if k.is_zero():
        return Response((L + 2 * G) * C_a, S_a, acb(0))
    beta2 = k * k + rho * kappa / G
    C_b, S_b = _hyperbolic(beta2, height)
    k2 = k * k
    mixed = beta2 + k2
    u_1 = (alpha2 * S_a - k2 * S_b) / kappa
    shear_1 = G * k * (mixed * S_b - 2 * alpha2 * S_a) / kappa
    pressure_1 = G * (mixed * C_a - 2 * k2 * C_b) / kappa
    u_2 = k * (C_a - C_b) / kappa
    shear_2 = G * (mixed * C_b - 2 * k2 * C_a) / kappa
    pressure_2 = G * k * (mixed * S_a - 2 * beta2 * S_b) / kappa
    return Response(
        free=shear_1 * pressure_2 - shear_2 * pressure_1,
        normal=shear_1 * u_2 - shear_2 * u_1,
        tangential=pressure_2 * u_1 - pressure_1 * u_2,
    )


def mirrored(response: Response) -> Response:
    """Response of the layer seen upside down: normal displacement and shear stress turn."""
    return Response(response.free, -response.normal, response.tangential)


def _hyperbolic(square: acb, y: arb) -> tuple[acb, acb]:
    """cosh(a y) and sinh(a y) / a, entire in a^2."""
    a = square.sqrt() * y
    return a.cosh(), y * (a * acb(0, 1)).sinc()
