"""Abaqus and CalculiX decks: what is read of them are nodes, elements, sets and surfaces."""
