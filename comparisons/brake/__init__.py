"""The scene ``ventilated_brake`` on three meshes and with three contact stiffnesses: `cea brake`."""
