"""From what a scene says to bodies, contacts and their coupled system."""
