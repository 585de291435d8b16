"""Prices beside those of the settings: solvers, effects, numbers of bands."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final, TypeAlias

from hradiosity.errors import SceneError
from hradiosity.model.scene import Scene
from hradiosity.plan import Plan
from hradiosity.suites.cost.budget import Budget
from hradiosity.suites.cost.pricing import bands_prices, effect_price
from hradiosity.suites.cost.protocols import Bench, Event
from hradiosity.suites.cost.settings import BANDS, FORCED, SOLVERS, Setting, for_bands, for_solver, forced
from hradiosity.suites.cost.values import BandsPrice, EffectPrice, Run, SolverPrice

SLOWER_THAN_CG: Final = {"southwell": 60.0, "overshooting": 15.0, "jacobi": 15.0, "gauss-seidel": 15.0, "auto": 2.0}
"""Seconds of other solvers over those of the conjugate gradients in a bright room (README); none is much slower."""
DENSE_SECONDS, DENSE_ELEMENTS, DENSE_COLUMNS = 5.0, 542, 81
"""What direct solvers took for so many elements and columns; it grows with the third power of the elements."""

Skip: TypeAlias = Callable[[Setting, float | None, str], Event]
"""Notes that a setting was not run: predicted wall seconds, and why."""
OVER: Final = "more than was left of their share of the budget"


class Extras:
    """What is measured once the settings are.

    Parameters
    ----------
    bench : Bench
    budget : Budget
    skip : callable
    in_bands : callable, optional
        (n) → the scene in n bands; None leaves that table out.
    """

    def __init__(
        self, bench: Bench, budget: Budget, skip: Skip, in_bands: Callable[[int], Scene] | None = None
    ) -> None:
        self._bench, self._budget, self._skip, self._in_bands = bench, budget, skip, in_bands
        self.solvers: list[SolverPrice] = []
        self.effects: list[EffectPrice] = []
        self._bands: list[tuple[int, int, Run]] = []
        self._solve_seconds = 0.0

    @property
    def bands(self) -> list[BandsPrice]:
        """Prices of numbers of bands so far."""
        return bands_prices(self._bands)

    def try_solvers(self, share: float) -> Iterator[Event]:
        """Each solver on draft's elements."""
        for name in SOLVERS:
            setting = for_solver(name)
            guess = self._bench.guess(setting)
            if guess is not None and not self._budget.holds(guess, share):
                yield self._skip(setting, guess, OVER)
                continue
            try:
                started = self._bench.start(setting)
            except SceneError as error:
                yield self._skip(setting, None, f"too many elements: {error.faults[0].found}")
                continue
            seconds = self._solver_seconds(name, started.plan)
            if not self._budget.holds(seconds, share):
                yield self._skip(setting, seconds, OVER)
                continue
            run = self._bench.finish(started)
            found = run.convergence
            if not found:
                return
            price = SolverPrice(name, run.elements, found["seconds"], found["products"], found["residual"][-1])
            self._solve_seconds = price.cpu_seconds if name == "cg" else self._solve_seconds
            self.solvers.append(price)
            yield Event("solver", price.__dict__ | {"spent": self._budget.spent})

    def _solver_seconds(self, name: str, plan: Plan) -> float:
        """Wall seconds of two replicates, about."""
        if name in SLOWER_THAN_CG:
            return 2.0 * SLOWER_THAN_CG[name] * self._solve_seconds
        if name == "cg":
            return 0.0
        return 2.0 * DENSE_SECONDS * (plan.n_elements / DENSE_ELEMENTS) ** 3 * plan.columns.n_columns / DENSE_COLUMNS

    def try_effects(self, runs: Sequence[Run], share: float) -> Iterator[Event]:
        """Each effect that may be forced, at the best quality that the time allows."""
        usual = next((run for run in reversed(runs) if run.setting.name in ("draft", "normal")), None)
        if usual is None:
            return
        if not self._budget.holds(len(FORCED) * usual.wall_seconds, share):
            usual = next(run for run in runs if run.setting.group == "quality")
        for name, flags, change in FORCED:
            setting = Setting(name, "effect", forced(usual.setting.options, change))
            if not self._budget.holds(usual.wall_seconds, share):
                yield self._skip(setting, usual.wall_seconds, OVER)
                continue
            price = effect_price(name, flags, usual, self._bench.finish(self._bench.start(setting)))
            self.effects.append(price)
            yield Event("effect", price.__dict__ | {"spent": self._budget.spent})

    def try_bands(self, runs: Sequence[Run], share: float) -> Iterator[Event]:
        """The scene in other bands, two numbers of them at least, since they are compared with each other."""
        draft = next((run for run in runs if run.setting.name == "draft"), None)
        if draft is None or self._in_bands is None:
            return
        per_column = draft.wall_seconds
        for count in BANDS:
            setting = for_bands(count)
            if not self._budget.holds(per_column if self._bands else 3.0 * per_column, share):
                yield self._skip(setting, per_column, OVER)
                continue
            try:
                scene = self._in_bands(count)
            except SceneError as error:
                yield self._skip(setting, None, error.faults[0].found)
                continue
            started = self._bench.start(setting, scene=scene)
            before = self._budget.spent
            run = self._bench.finish(started)
            columns = started.plan.columns.n_columns
            self._bands.append((count, columns, run))
            longer = BANDS[min(BANDS.index(count) + 1, len(BANDS) - 1)] / count
            per_column = max(self._budget.spent - before, draft.wall_seconds) * max(longer / 2.0, 1.0)
            values = {"bands": count, "columns": columns, "cpu_seconds": run.cpu_seconds}
            yield Event("bands", values | {"spent": self._budget.spent})
