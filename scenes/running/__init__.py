"""From a scene to its result, a module for each kind of analysis."""
