"""A mended copy of a scene: what `hradiosity check` finds and can be put right without asking."""
