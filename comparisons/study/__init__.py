"""The engine of every study: cases -> rows -> sections of a page.

A study is a list of cases, a function that computes one, and sections that show the rows::

    from dataclasses import dataclass
    from comparisons.study.columns import Column
    from comparisons.study.result import StudyResult
    from comparisons.study.sections import Plot, Section, Table
    from comparisons.study.study import Study

    @dataclass(frozen=True)
    class Options:                       # options of the command
        backends: tuple[str, ...] = ("fe", "iga")

    def cases(options):                  # labels of each case: plain values
        for backend in options.backends:
            for p in (1e2, 1e4):
                yield {"backend": backend, "p": p}

    def scene(case, options):            # part of what a stored case must agree in
        blocks = load_scene("blocks", [f"contacts.interface.p={case['p']}"])
        return on_backend(blocks, case["backend"])

    def evaluate(case, session):         # a row, rows, or rows by the name of their table
        result = session.solve()         # bodies are reused from case to case
        return {"growth": float(result.growth_rates.max())}

    STUDY = Study("growth", "Growth against p", Options, cases, evaluate,
                  [Section("Growth", tables=[Table("growth", "Largest.", StudyResult.frame)])],
                  scene=scene)

:func:`comparisons.study.run.run` runs it, resumes it where it was killed, and gives a
:class:`~comparisons.study.result.StudyResult`; :func:`comparisons.study.page.write_study` writes
record, CSV files, PNG files and the page. A name in ``comparisons/cli/study.py`` makes it a
command. ``docs/how_to_add_a_study.md`` has a whole one.
"""
