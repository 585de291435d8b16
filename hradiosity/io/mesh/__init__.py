"""Mesh files: one module a format, read and cleaned in a process of their own."""
