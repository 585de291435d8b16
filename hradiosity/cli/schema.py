"""``hradiosity schema``."""

from __future__ import annotations


def schema() -> int:
    """Print the JSON Schema of scene files, for editors that complete and check them."""
    import json

    from hradiosity.io.scene.schema import scene_json_schema

    print(json.dumps(scene_json_schema(), indent=1))
    return 0
