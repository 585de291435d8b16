"""Time to build the ray structure."""

from __future__ import annotations

from hradiosity.space.bvh_build import build_bvh
from hradiosity.suites.bench.figure import CPU, WALL, Figure, figure_of
from hradiosity.suites.bench.session import Session, cpu_and_wall
from hradiosity.suites.bench_rooms import HUGE, furnished_room


def measure(session: Session) -> list[Figure]:
    """100 000 triangles."""
    patches = furnished_room(HUGE)

    def build() -> None:
        build_bvh(session.device, patches)
        session.device.finish()

    build()
    spent = [cpu_and_wall(build) for _ in range(session.turns)]
    name = "bvh: 100 000 triangles"
    return [figure_of(name, [cpu for cpu, _ in spent], CPU), figure_of(name, [wall for _, wall in spent], WALL)]
