"""The scene ``ventilated_brake`` on several meshes, with several contact stiffnesses."""
