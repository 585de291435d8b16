"""Spectral radiosity for lighting research."""

__version__ = "0.1.0"
