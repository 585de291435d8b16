"""The account of a run as arrays, beside the moments that a checkpoint keeps."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.options import Options
from hradiosity.radiosity.budget import Round
from hradiosity.radiosity.record import Record
from hradiosity.solvers.result import Convergence, Stage
from hradiosity.transport.exchange import Defects


def pack_record(record: Record, **numbers: float) -> NDArray[np.uint8]:
    """A record and some more numbers as the bytes of a JSON text; floats keep their bits."""
    text = json.dumps(
        {
            "seconds": record.seconds,
            "rays": record.rays,
            "hemicubes": record.hemicubes,
            "hemicube_seconds": record.hemicube_seconds,
            "defects": [asdict(d) for d in record.defects],
            "convergence": [asdict(c) for c in record.convergence],
            "numbers": numbers,
        }
    )
    return np.frombuffer(text.encode(), np.uint8)


def unpack_record(packed: NDArray[np.uint8]) -> tuple[Record, Mapping[str, float]]:
    """The inverse of `pack_record`."""
    found: dict[str, Any] = json.loads(packed.tobytes())
    record = Record(
        seconds=found["seconds"],
        rays=found["rays"],
        hemicubes=found["hemicubes"],
        hemicube_seconds=found["hemicube_seconds"],
        defects=[Defects(**d) for d in found["defects"]],
        convergence=[_convergence(c) for c in found["convergence"]],
    )
    return record, found["numbers"]


def _convergence(found: dict[str, Any]) -> Convergence:
    stages = tuple(Stage(**stage) for stage in found["stages"])
    return Convergence(**(found | {"residual": tuple(found["residual"]), "stages": stages}))


def pack_round(size: Round, given_up: list[dict[str, float]]) -> NDArray[np.uint8]:
    """How large the replicates are, and the rounds before, as the bytes of a JSON text."""
    of_readings = {"focus": size.focus.tolist(), "lookup": size.lookup.tolist()}
    text = json.dumps({"options": asdict(size.options), **of_readings, "given_up": given_up})
    return np.frombuffer(text.encode(), np.uint8)


def unpack_round(packed: NDArray[np.uint8]) -> tuple[Round, list[dict[str, float]]]:
    """The inverse of `pack_round`."""
    found: dict[str, Any] = json.loads(packed.tobytes())
    of_readings = np.array(found["focus"], np.float64), np.array(found["lookup"], np.int64)
    return Round(Options(**found["options"]), *of_readings), found["given_up"]
