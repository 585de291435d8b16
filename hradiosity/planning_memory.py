"""Whether a run fits into memory, told before anything large is allocated."""

from __future__ import annotations

from typing import Final

import numpy as np

from hradiosity.device import Device
from hradiosity.device.host_memory import available_host_bytes
from hradiosity.errors import Fault, SceneError
from hradiosity.plan import Plan

SPARE: Final = 0.9
"""Share of the memory at hand that advice makes use of."""
RAY_BYTES: Final = 96
"""Of an exchange ray: what it met, on device and host, and its share of the sparse matrices on the way to the exchange;
85 were measured."""
EMITTER_BYTES: Final = 12
"""Of an element and an emitter."""
GROUP_BYTES: Final = 1024
"""Of an element and a group of eight columns: solver, moments and what results are made of, as measured."""
PATH_BYTES: Final = 48
"""Of a path from a reading; 41 were measured."""
KEPT_LIGHT_BYTES: Final = 768 * 2**20
"""Light of earlier replicates that is kept on the device for reading points again, and further ones; that of the first
two always is."""
KEPT_SAMPLE_BYTES: Final = 512 * 2**20
"""Samples of all replicates, for points that are read again; where there are more, none are kept."""


def element_bytes(plan: Plan) -> int:
    """Bytes that grow with the elements: hits, links, direct light, columns of the solver."""
    rays = RAY_BYTES * plan.rays_per_element + EMITTER_BYTES * plan.n_emitters
    return plan.n_elements * (rays + GROUP_BYTES * plan.columns.n_groups)


def path_bytes(plan: Plan) -> int:
    """Bytes of the paths from all readings."""
    return PATH_BYTES * plan.n_readings * plan.gather_samples


def kept_bytes(plan: Plan) -> int:
    """Bytes of what replicates leave for later: their light on the elements and their samples of the readings."""
    columns = plan.columns
    light = plan.n_elements * (4 + 2 * 4 * plan.n_emitters + 2 * 4 * 8 * columns.n_groups)
    samples = 2 * 8 * plan.n_readings * columns.n_columns
    return kept_light_bytes(light, plan.replicates) + min(plan.replicates * samples, KEPT_SAMPLE_BYTES)


def kept_light_bytes(each: int, replicates: int) -> int:
    """Bytes of light that is kept, of replicates that have so many `each`."""
    return max(min(replicates, KEPT_LIGHT_BYTES // max(each, 1)), min(replicates, 2)) * each


def check_fits(plan: Plan, device: Device) -> None:
    """`check_memory` with what the device and the machine have now."""
    check_memory(plan, device.info.global_memory_bytes, available_host_bytes())


def check_memory(plan: Plan, device_bytes: int | None, host_bytes: int | None) -> None:
    """Refuse a run that needs more memory than there is; None where that is not known.

    Parameters
    ----------
    plan : Plan
        With ``memory_bytes``; arrays of the device have copies of about that size on the host.
    device_bytes, host_bytes : int, optional
        What the device has and what the machine can still give.

    Raises
    ------
    SceneError
        With what is needed, what there is, and the option that helps.
    """
    places = (("the device has", device_bytes), ("this machine has free", host_bytes))
    known = [(amount, words) for words, amount in places if amount is not None]
    if not known:
        return
    have, place = min(known)
    if plan.memory_bytes > have:
        found = f"the run needs about {_gib(plan.memory_bytes)}, {place} {_gib(have)}"
        option, most = _remedy(plan, have)
        raise SceneError([Fault("command line", option, found, f"{option} {most} or less")])


def _remedy(plan: Plan, have: int) -> tuple[str, int]:
    """The option that brings most, and the number with which the run fits."""
    paths = path_bytes(plan)
    other = plan.memory_bytes - paths
    room = SPARE * have
    if paths > other and other < room:
        wanted = plan.gather_samples * plan.replicates
        return "--gather-samples", max(plan.replicates, int(wanted * (room - other) / paths))
    share = max(room - paths, 0.0) / max(other, 1)
    of_pairs = bool(plan.pairs) or bool(plan.hemicubes)
    return "--elements", max(1, int(plan.n_elements * (np.sqrt(share) if of_pairs else share)))


def _gib(amount: int) -> str:
    return f"{amount / 2**30:.3g} GiB"
