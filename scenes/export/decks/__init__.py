"""Scenes written as input decks of other programs: Abaqus and CalculiX.

:func:`scenes.export.decks.write.write_deck` is what callers need.
"""
