"""How often intervals hold the true value, and how wide they are for that: ``python -m hradiosity.suites.coverage``."""
