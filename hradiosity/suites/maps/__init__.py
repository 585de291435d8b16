"""How well the illuminance on surfaces is mapped, against unbiased paths: ``python -m hradiosity.suites.maps``."""
