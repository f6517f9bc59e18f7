"""Figures and claims of the paper: ``cea paper``.

Mohanasundaram, Shimoyama, Gillot and Besset, "Modelling Friction-Induced Dynamic Instability
Dedicated for Isogeometric Formulation", Shock and Vibration (2023).
"""
