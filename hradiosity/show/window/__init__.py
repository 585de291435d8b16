"""The window of ``hradiosity view``: pyvista and VTK only in `stage` and `app`, everything else pure functions."""
