"""Images beside path-traced ones of the same view: how far they are apart, and where."""
