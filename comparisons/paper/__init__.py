"""Figures of the paper and what its text claims: ``cea paper``.

Mohanasundaram, Shimoyama, Gillot and Besset, "Modelling Friction-Induced Dynamic Instability
Dedicated for Isogeometric Formulation", Shock and Vibration (2023). A figure is a row of
:mod:`comparisons.paper.figures` that follows :class:`comparisons.paper.figure.Figure`, a claim a
row of :mod:`comparisons.paper.claims`.
"""
