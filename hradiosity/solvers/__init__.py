"""Iterations over the exchange operator; no geometry."""
