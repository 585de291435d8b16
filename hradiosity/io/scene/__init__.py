"""The scene file: what may stand in it, and how its parts become a `Scene`."""
