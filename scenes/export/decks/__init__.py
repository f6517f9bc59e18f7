"""Export of scenes as input decks of CalculiX.

The entry point is :func:`scenes.export.decks.calculix.write_deck`.
"""
