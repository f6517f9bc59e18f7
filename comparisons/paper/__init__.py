"""The paper's figures, each computed, stored, drawn and set beside the numbers of its text.

Mohanasundaram, Shimoyama, Gillot and Besset, "Modelling Friction-Induced Dynamic Instability
Dedicated for Isogeometric Formulation", Shock and Vibration (2023). A figure is a value that
follows :class:`comparisons.paper.common.figure.PaperFigure`; :mod:`comparisons.paper.registry`
lists them by name, and :mod:`comparisons.paper.common.store` keeps what was computed, so that
drawing anew computes nothing.
"""
