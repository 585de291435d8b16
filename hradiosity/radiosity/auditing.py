"""The audit: some readings once more by unbiased paths, to see whether the intervals hold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.estimate import student_quantile
from hradiosity.metrics.photometric import illuminance
from hradiosity.model.scene import Scene
from hradiosity.readings.audit import LEAST_READINGS, LEVEL, Verdict, audit_order, judge, pooled_noise
from hradiosity.readings.audit_batch import ReadingBatch
from hradiosity.readings.path_scene import RefereeScene, prepare_referee
from hradiosity.readings.paths import SCRAMBLES
from hradiosity.solution import Solution
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.parted import part_back_to_back
from hradiosity.transport.device_scene import upload_scene

RAYS_SHARE: Final = 0.24
"""Rays that an audit may trace over what the run did, counted in rays. A ray of unbiased paths takes no longer than one
of a run, so that this is less than a quarter of the run's CPU seconds; a limit in seconds would make results depend on
the clock."""
ELEMENT_RAYS: Final = 80
"""Rays that take about as long as all else that a replicate does for an element: pairing, closing, solving."""
HEMICUBE_RAYS: Final = 14_000
"""Rays that take about as long as drawing a hemicube and what it is drawn for, or less."""
USUAL_READINGS: Final = 59
"""The least with which the factor is not the largest ratio but the third largest: one odd reading does not decide."""
MOST_READINGS: Final = 299
MOST_AUDITS: Final = 3
"""Of a run that goes on until readings are accurate with the audit's factor too."""
ENOUGH_NOISE: Final = 0.5
"""Noise over half width below which more paths would not tell more."""
ENOUGH_READINGS: Final = 0.75
"""Share of the audited readings that are to have so little noise."""
_FIRST_PATHS = 4
_ILLUMINANCE = ("illuminance", "illuminance_half_width")


@dataclass(frozen=True)
class Audit:
    """What an audit did and found.

    verdict : of the intervals
    chosen : indices of the audited readings by sensor name
    paths : from each of them
    rays, cpu_seconds : that it took
    """

    verdict: Verdict
    chosen: Mapping[str, tuple[int, ...]]
    paths: int
    rays: int
    cpu_seconds: float

    @property
    def readings(self) -> int:
        """Number of audited readings."""
        return sum(len(indices) for indices in self.chosen.values())

    def record(self) -> dict[str, Any]:
        """For ``run.json``."""
        return {
            "readings": self.readings,
            **asdict(self.verdict),
            "paths": self.paths,
            "rays": self.rays,
            "cpu_s": self.cpu_seconds,
            "chosen": {name: list(indices) for name, indices in self.chosen.items()},
        }


@dataclass(frozen=True)
class AuditState:
    """Where an audit stands: readings, paths from each, rays traced of those it may trace."""

    readings: int
    paths: int
    rays: int
    most_rays: int


def no_audit_because(solution: Solution) -> str | None:
    """Why the solution can't be audited; None if it can."""
    options = solution.record["options"]
    off = [name for name in ("occlusion", "interreflection") if options[name] is False]
    if off:
        return f"{' and '.join(off)} switched off, which unbiased paths do not know of"
    if solution.replicates < 2:
        return "one replicate has no intervals"
    if int(_auditable(solution).sum()) < LEAST_READINGS:
        return f"fewer than {LEAST_READINGS} readings with light"
    return None


def most_rays(solution: Solution) -> int:
    """Rays that an audit may trace; its first round is traced in any case.

    Replicates of which nothing was kept do not count, since a run that repeats the others lacks them.
    """
    record = solution.record
    given_up = [some["rays"] for some in record["rounds_given_up"] if not some["readings_kept"]]
    rays = record["rays"] - max(given_up, default=0)
    elements = ELEMENT_RAYS * record["elements"] * solution.replicates
    return int(RAYS_SHARE * (rays + elements + HEMICUBE_RAYS * record["hemicubes"]["drawn"]))


def _auditable(solution: Solution) -> NDArray[np.bool_]:
    """(n,) which readings have an interval, and are planes; those that are dark for certain have no interval."""
    half_width = _of_readings(solution, "illuminance_half_width")
    kinds = np.repeat(
        [r.kind == "plane" for r in solution.readings.values()], [len(r) for r in solution.readings.values()]
    )
    usable: NDArray[np.bool_] = np.isfinite(half_width) & (half_width > 0.0) & kinds.astype(bool)
    return usable


def _of_readings(solution: Solution, name: str) -> NDArray[np.float64]:
    """An attribute of all readings, one sensor after the other."""
    return np.concatenate([np.zeros(0), *(getattr(found, name) for found in solution.readings.values())])


class Auditor:
    """An audit that can be followed round by round; one that is broken off has found nothing.

    The number of readings and paths follows from the rays of the run and from the audit's own noise, not from time.

    Parameters
    ----------
    scene : Scene
        As it was modelled.
    solution : Solution
        One for which `no_audit_because` knows no reason.
    device : Device
    """

    def __init__(self, scene: Scene, solution: Solution, device: Device) -> None:
        self.cpu_seconds = 0.0
        self._scene, self._solution, self._device = part_back_to_back(scene), solution, device
        self._most_rays = most_rays(solution)
        self._run_seed = int(solution.record["options"]["seed"])
        self._sensor = np.repeat(np.arange(len(solution.readings)), [len(r) for r in solution.readings.values()])
        usable = np.flatnonzero(_auditable(solution))
        self._order = usable[audit_order(self._sensor[usable], _seed(self._run_seed, 2))]
        self._batches: list[ReadingBatch] = []
        self._done = False

    def states(self) -> Iterator[AuditState]:
        """Run, yielding after each round."""
        cpu = self._device.work_cpu_seconds()
        bvh = build_bvh(self._device, self._scene.patches)
        referee = prepare_referee(upload_scene(self._device, self._scene, bvh, occlusion=True), self._scene)
        for batch in self._rounds(referee):
            self.cpu_seconds += self._device.work_cpu_seconds() - cpu
            readings = sum(len(batch.chosen) for batch in self._batches)
            yield AuditState(readings, batch.paths * SCRAMBLES, self._rays, self._most_rays)
            cpu = self._device.work_cpu_seconds()

    def audit(self) -> Audit:
        """What was found.

        Raises
        ------
        RuntimeError
            Before all rounds are done.
        """
        if not self._done:
            raise RuntimeError("the audit was broken off")
        chosen = np.concatenate([batch.chosen for batch in self._batches])
        unbiased, noise = self._unbiased()
        value, half_width = (_of_readings(self._solution, name)[chosen] for name in _ILLUMINANCE)
        names, sizes = list(self._solution.readings), [len(found) for found in self._solution.readings.values()]
        first = np.cumsum([0, *sizes])
        known = {
            name: tuple(int(k) for k in np.sort(chosen[self._sensor[chosen] == i]) - first[i])
            for i, name in enumerate(names)
        }
        return Audit(
            verdict=judge(value, unbiased, half_width, noise),
            chosen={name: indices for name, indices in known.items() if indices},
            paths=self._batches[0].paths * SCRAMBLES,
            rays=self._rays,
            cpu_seconds=self.cpu_seconds,
        )

    @property
    def _rays(self) -> int:
        return sum(batch.rays for batch in self._batches)

    def _rounds(self, referee: RefereeScene) -> Iterator[ReadingBatch]:
        """Paths of the usual number of readings until there is little noise; then as many of further readings."""
        usual = self._batch(self._order[:USUAL_READINGS])
        step = max(1, round(1.0 / referee.direct_share))
        count = max(step, _FIRST_PATHS)
        while count:
            usual.trace(referee, count)
            yield usual
            left = int((self._most_rays - self._rays) / usual.rays_per_path)
            count = 0 if self._clear() else max(0, min(usual.paths, usual.round_paths, left)) // step * step
        each = usual.rays / len(usual.chosen)
        most = min(MOST_READINGS, len(usual.chosen) + int((self._most_rays - self._rays) / each))
        if self._clear() and most > len(usual.chosen):
            further = self._batch(self._order[len(usual.chosen) : most])
            while further.paths < usual.paths:
                size = max(step, further.round_paths // step * step)
                further.trace(referee, min(size, usual.paths - further.paths))
                yield further
        self._done = True

    def _batch(self, chosen: NDArray[np.int64]) -> ReadingBatch:
        """Some more readings that are traced together."""
        position, normal = (
            np.concatenate([getattr(found, name) for found in self._solution.readings.values()])[chosen]
            for name in ("position", "normal")
        )
        batch = ReadingBatch(
            chosen, position, normal, len(self._scene.bands), _seed(self._run_seed, len(self._batches))
        )
        self._batches.append(batch)
        return batch

    def _unbiased(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(n,) illuminances of the audited readings [lx] and half widths of their own."""
        chosen = np.concatenate([batch.chosen for batch in self._batches])
        spectra = np.concatenate([batch.per_scramble for batch in self._batches], axis=1)
        lux = illuminance(spectra, self._scene.bands)
        error = lux.std(axis=0, ddof=1) / np.sqrt(SCRAMBLES)
        noise = pooled_noise(error, _of_readings(self._solution, "illuminance")[chosen])
        return lux.mean(axis=0), student_quantile(LEVEL, SCRAMBLES - 1) * noise

    def _clear(self) -> bool:
        """Whether there is so little noise that more paths would hardly tell more."""
        chosen = np.concatenate([batch.chosen for batch in self._batches])
        half_width = _of_readings(self._solution, "illuminance_half_width")[chosen]
        return float(np.mean(self._unbiased()[1] <= ENOUGH_NOISE * half_width)) >= ENOUGH_READINGS


def _seed(run_seed: int, batch: int) -> int:
    """Random numbers that neither the replicates nor ``--referee`` have."""
    return int(np.random.SeedSequence((run_seed, batch, 0xA0D17)).generate_state(1)[0])


def audited(solution: Solution, found: Audit) -> Solution:
    """The solution with all half widths multiplied by what the audit found."""
    factor, reader, reflector = found.verdict.factor, solution.reader, solution.reflector
    return replace(
        solution,
        readings={name: readings.widened(factor) for name, readings in solution.readings.items()},
        variants={name: variant.widened(factor) for name, variant in solution.variants.items()},
        record={**solution.record, "audit": found.record()},
        reader=None if reader is None else lambda sensor: reader(sensor).widened(factor),
        reflector=None if reflector is None else lambda *what: reflector(*what).widened(factor),
    )


def missed_by_factor(solution: Solution) -> float | None:
    """Accuracy of the worst reading, where the audit's factor alone keeps it from the one asked for; else None."""
    wanted = solution.record["options"]["accuracy"]
    factor = solution.record.get("audit", {}).get("factor", 1.0)
    worst = max((float(found.accuracy.max()) for found in solution.readings.values()), default=0.0)
    return None if wanted is None or factor <= 1.0 or not wanted < worst <= factor * wanted else worst


def accuracy_before_factor(solution: Solution) -> float | None:
    """Accuracy to go on to where only the audit's factor is in the way; None elsewhere, and where time is limited."""
    options = solution.record["options"]
    if missed_by_factor(solution) is None or options["time"] is not None:
        return None
    return float(options["accuracy"] / solution.record["audit"]["factor"])


def audit(solution: Solution, device: Device | None = None, *, scene: Scene | None = None) -> Solution:
    """Check the intervals by unbiased paths from some readings, drawn at random.

    Parameters
    ----------
    solution : Solution
    device : Device, optional
        That the paths are traced on.
    scene : Scene, optional
        As it was modelled; that of the solution has its patches cut where others stand on them, with the same light.

    Returns
    -------
    Solution
        With all half widths, those of points read later included, multiplied by the factor that was found, and what
        was found in ``record["audit"]``; or with the reason for no audit there.
    """
    reason = no_audit_because(solution)
    if reason is not None:
        return not_audited(solution, reason)
    auditor = Auditor(scene or solution.scene, solution, device or Device())
    for _ in auditor.states():
        pass
    return audited(solution, auditor.audit())


def not_audited(solution: Solution, reason: str) -> Solution:
    """The solution with the reason for no audit in ``record["audit"]``."""
    return replace(solution, record={**solution.record, "audit": {"skipped": reason}})
