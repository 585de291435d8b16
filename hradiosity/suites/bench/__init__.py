"""One run of all benchmarks, kept as JSON, and the ratios of two such runs: ``python -m hradiosity.bench``."""
