"""What ``hradiosity cost`` learnt about a scene on a device: how many replicates an accuracy takes, and how long."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Final

from hradiosity.estimate import student_quantile
from hradiosity.io.cache import load_devices, store_devices
from hradiosity.options import Options

_FILE: Final = "cost.json"
MOST_REPLICATES: Final = 256
_KEPT_SCENES: Final = 50
_APART: Final = ("accuracy", "time", "seed", "pictures", "full_metrics")
"""Options that do not change what one replicate takes, or how much it varies."""


@dataclass(frozen=True)
class Learnt:
    """What one setting took.

    spread : standard deviation of one replicate over the base of `Readings.accuracy`, of the worst reading
    first_seconds : wall seconds before the first replicate
    replicate_seconds : wall seconds of each
    error : of the illuminances against the referee, relative, root mean square
    sampling : the part of it that comes from sampling, with the setting's replicates
    """

    spread: float
    first_seconds: float
    replicate_seconds: float
    error: float
    sampling: float

    def replicates_for(self, accuracy: float) -> int | None:
        """Fewest whose interval is as narrow as wanted at the worst reading; None when that is too many."""
        for count in range(2, MOST_REPLICATES + 1):
            if student_quantile(0.95, count - 1) * self.spread / count**0.5 <= accuracy:
                return count
        return None

    def seconds_for(self, replicates: int) -> float:
        """Wall seconds."""
        return self.first_seconds + replicates * self.replicate_seconds


def key_of(options: Options) -> str:
    """The options that matter as text."""
    return json.dumps({name: value for name, value in asdict(options).items() if name not in _APART})


def load_learnt(device: str, digest: str, options: Options) -> Learnt | None:
    """What is known about a setting of a scene on a device; None when it was never measured."""
    kept = load_devices(_FILE).get(device, {}).get(digest, {}).get(key_of(options))
    if not isinstance(kept, dict) or kept.keys() != {field.name for field in fields(Learnt)}:
        return None
    return Learnt(**{name: float(value) for name, value in kept.items()})


def store_learnt(device: str, digest: str, found: Sequence[tuple[Options, Learnt]]) -> bool:
    """Keep what was measured; what is known of other scenes and devices stays.

    Returns
    -------
    bool
        False when the cache can't be written, which harms nothing.
    """
    kept = load_devices(_FILE)
    scenes = kept.setdefault(device, {})
    scenes[digest] = scenes.pop(digest, {}) | {key_of(options): asdict(learnt) for options, learnt in found}
    kept[device] = dict(list(scenes.items())[-_KEPT_SCENES:])
    return store_devices(_FILE, kept)


def accuracy_line(learnt: Learnt | None, accuracy: float, options: Options) -> str:
    """What is expected of ``--accuracy``, in words."""
    wanted = f"accuracy {100.0 * accuracy:.2g} %"
    if learnt is None:
        return f"{wanted}: not measured for this scene and these settings: run hradiosity cost"
    count = learnt.replicates_for(accuracy)
    if count is None:
        return f"{wanted}: more than {MOST_REPLICATES} replicates, as hradiosity cost measured; raise the samples"
    count = max(count, options.replicates)
    rest = max(learnt.error**2 - learnt.sampling**2, 0.0) ** 0.5
    remark = f"; {100.0 * rest:.2g} % of error is not sampling and stays" if rest > accuracy / 2.0 else ""
    return (
        f"{wanted}: about {learnt.seconds_for(count):.2g} s in {count} replicates, as hradiosity cost measured{remark}"
    )
