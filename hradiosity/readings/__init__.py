"""The light at a point, and the interval it carries."""
