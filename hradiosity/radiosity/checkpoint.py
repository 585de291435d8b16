"""The account of a run as arrays, beside the moments that a checkpoint keeps."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.options import Options
from hradiosity.radiosity.budget import Step
from hradiosity.radiosity.record import Record
from hradiosity.solvers.result import Convergence, Stage
from hradiosity.transport.exchange import Defects

_OF_READINGS: Final[dict[str, Any]] = {"times": np.float64, "lookup": np.int64, "anew": np.bool_}


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
            "numbers": {"cpu_seconds": record.cpu_seconds, **numbers},
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
        cpu_seconds=found["numbers"]["cpu_seconds"],
        defects=[Defects(**d) for d in found["defects"]],
        convergence=[_convergence(c) for c in found["convergence"]],
    )
    return record, found["numbers"]


def _convergence(found: dict[str, Any]) -> Convergence:
    stages = tuple(Stage(**stage) for stage in found["stages"])
    return Convergence(**(found | {"residual": tuple(found["residual"]), "stages": stages}))


def pack_numbers(numbers: Mapping[str, float]) -> NDArray[np.uint8]:
    """Numbers by name as the bytes of a JSON text; they keep their bits."""
    return np.frombuffer(json.dumps(dict(numbers)).encode(), np.uint8)


def unpack_numbers(packed: NDArray[np.uint8]) -> dict[str, float]:
    """The inverse of `pack_numbers`."""
    found: dict[str, float] = json.loads(packed.tobytes())
    return found


def pack_pace(
    size: Options, given_up: list[dict[str, float]], deeper: int, step: Step | None, number: int
) -> NDArray[np.uint8]:
    """How large the replicates are, the rounds before, and the step that a run is in, as the bytes of a JSON text."""
    going_on = None
    if step is not None:
        of_readings = {name: getattr(step, name).tolist() for name in _OF_READINGS}
        going_on = {"options": asdict(step.options), "larger": step.larger, **of_readings}
    text = json.dumps(
        {"size": asdict(size), "given_up": given_up, "deeper": deeper, "step": going_on, "number": number}
    )
    return np.frombuffer(text.encode(), np.uint8)


def unpack_pace(packed: NDArray[np.uint8]) -> tuple[Options, list[dict[str, float]], int, Step | None, int]:
    """The inverse of `pack_pace`."""
    found: dict[str, Any] = json.loads(packed.tobytes())
    step = found["step"]
    if step is not None:
        of_readings = {name: np.array(step[name], kind) for name, kind in _OF_READINGS.items()}
        step = Step(Options(**step["options"]), larger=step["larger"], **of_readings)
    return Options(**found["size"]), found["given_up"], found["deeper"], step, found["number"]
