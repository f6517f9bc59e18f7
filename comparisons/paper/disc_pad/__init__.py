"""The paper's disc and pad: Figures 4 to 6 and 13 to 15."""
