"""Construction of bodies, contacts and the coupled system of a scene."""
