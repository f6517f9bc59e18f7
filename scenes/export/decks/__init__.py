"""Export of scenes as input decks of CalculiX.

The entry point is :func:`scenes.export.decks.write.write_deck`.
"""
