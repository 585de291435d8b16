"""Slow float64 twins and closed forms, for tests and validation only."""
