"""What accuracy costs in time on a scene: every setting measured against unbiased paths."""
