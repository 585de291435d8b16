"""Programs that run hradiosity against something: benchmarks."""
