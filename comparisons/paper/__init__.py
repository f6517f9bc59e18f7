"""Figures of the paper and what its text claims: ``cea paper``.

Mohanasundaram, Shimoyama, Gillot and Besset, "Modelling Friction-Induced Dynamic Instability
Dedicated for Isogeometric Formulation", Shock and Vibration (2023).
"""
