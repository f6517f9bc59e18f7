"""Error of flutter eigenvalues against run time: every discretisation with every formulation.

A study is data (:mod:`~comparisons.accuracy.study`): problems with exact eigenvalues, methods,
meshes, contact stiffnesses. Its cases are run one at a time in a process of their own, which may
fail without harm (:mod:`~comparisons.accuracy.runner`); what was measured is kept as JSON, from
which tables, figures and words are drawn anew without running anything.
"""
