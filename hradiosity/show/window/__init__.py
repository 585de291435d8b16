"""The window of ``hradiosity view``: VTK only in `stage`, `events` and `overlays`, all else pure functions."""
