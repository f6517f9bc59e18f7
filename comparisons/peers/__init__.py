"""CalculiX beside this program on the same meshes: `cea bench calculix`."""
