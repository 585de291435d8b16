"""Measures a scene within a budget: qualities, single knobs, combinations, solvers, effects, bands, other seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol

from hradiosity.errors import SceneError
from hradiosity.model.scene import Scene
from hradiosity.plan import Plan
from hradiosity.solution import Readings
from hradiosity.suites.cost.budget import Budget
from hradiosity.suites.cost.combine import Change, propose
from hradiosity.suites.cost.pricing import Truth, bands_prices, effect_price, prices
from hradiosity.suites.cost.settings import (
    BANDS,
    FORCED,
    KNOBS,
    SOLVERS,
    Setting,
    classic,
    combined,
    for_bands,
    for_solver,
    forced,
    qualities,
    single_knobs,
    warm_up,
)
from hradiosity.suites.cost.values import BandsPrice, EffectPrice, Price, Run, Skipped, SolverPrice

FIRST_REFERENCE: Final = 0.18
SWEEP: Final = 0.46
COMBINATIONS: Final = 0.54
SOLVING, EFFECTS, COUNTS = 0.58, 0.62, 0.68
LATER_REFERENCE: Final = 0.86
END: Final = 0.95
"""Shares of the budget after which each part ends, in their order; what one leaves over is the next one's. The last
twentieth is for writing."""
NOISE_GOAL: Final = 1.0 / 3.0
"""The reference is good enough when its noise is below this share of the best setting's error."""
MOST_COMBINATIONS: Final = 6
SEEDS: Final = 3
SAME_ELEMENTS: Final = 0.02
"""Two cuts whose numbers of elements differ by less are one."""
SLOWER_THAN_CG: Final = {"southwell": 60.0, "overshooting": 15.0, "jacobi": 15.0, "gauss-seidel": 15.0, "auto": 5.0}
"""Seconds of other solvers over those of the conjugate gradients in a bright room (README); none is much slower."""
DENSE_SECONDS, DENSE_ELEMENTS, DENSE_COLUMNS = 5.0, 542, 81
"""What direct solvers took for so many elements and columns; it grows with the third power of the elements."""


class StartedRun(Protocol):
    """A setting whose plan is made."""

    @property
    def plan(self) -> Plan:
        """What it will do."""
        ...

    @property
    def predicted(self) -> float | None:
        """Wall seconds until it is done."""
        ...


class Reference(Protocol):
    """See `hradiosity.suites.cost.reference.GrowingReference`."""

    @property
    def paths(self) -> int:
        """So far."""
        ...

    def advance(self, seconds: float) -> bool:
        """One round."""
        ...

    def noise(self) -> float:
        """Of the illuminances."""
        ...

    def readings(self) -> dict[str, Readings]:
        """So far."""
        ...


class Bench(Protocol):
    """See `hradiosity.suites.cost.bench.SceneBench`."""

    @property
    def reference(self) -> Reference:
        """The referee."""
        ...

    def clock(self) -> float:
        """Wall seconds."""
        ...

    def guess(self, setting: Setting) -> float | None:
        """Predicted wall seconds."""
        ...

    def start(self, setting: Setting, seed: int = 0, scene: Scene | None = None) -> Any:
        """Geometry and plan."""
        ...

    def finish(self, started: Any) -> Run:
        """The rest."""
        ...

    def learn(self, run: Run, plan: Plan) -> None:
        """Predict from this run."""
        ...


@dataclass(frozen=True)
class Event:
    """Something happened.

    kind : "run", "skipped", "reference", "solver", "effect" or "bands"
    """

    kind: str
    values: dict[str, Any]


class CostRun:
    """Measures one scene; follow its events, stop whenever you like, and ask for what is known.

    Parameters
    ----------
    bench : Bench
    seconds : float
        Budget of wall seconds.
    in_bands : callable, optional
        (n) → the scene in n bands; None leaves that table out.
    """

    def __init__(self, bench: Bench, seconds: float, in_bands: Callable[[int], Scene] | None = None) -> None:
        self.bench, self._in_bands = bench, in_bands
        self.budget = Budget(seconds, bench.clock)
        self.runs: list[Run] = []
        self.skipped: list[Skipped] = []
        self.solvers: list[SolverPrice] = []
        self.effects: list[EffectPrice] = []
        self._bands: list[tuple[int, int, Run]] = []
        self._solve_seconds = 0.0

    @property
    def bands(self) -> list[BandsPrice]:
        """Prices of numbers of bands so far."""
        return bands_prices(self._bands)

    def prices(self) -> list[Price]:
        """Prices of settings so far.

        Raises
        ------
        ValueError
            When there is no light to compare.
        RuntimeError
            Before the reference began.
        """
        return prices(self.runs, Truth.of(self.bench.reference.readings()))

    def events(self) -> Iterator[Event]:
        """Measure, yielding after each run."""
        self.bench.finish(self.bench.start(warm_up()))
        warm = self.bench.start(warm_up())
        self.bench.learn(self.bench.finish(warm), warm.plan)
        draft, normal, fine = qualities()
        yield from self._run(draft, 1.0, base=True)
        self.bench.reference.advance(self.budget.left(FIRST_REFERENCE))
        yield from self._run(normal, SWEEP, base=True)
        yield from self._refer(FIRST_REFERENCE)
        yield from self._sweep([fine, *single_knobs(), *classic()], SWEEP)
        yield from self._combine(COMBINATIONS)
        yield from self._try_solvers(SOLVING)
        yield from self._try_effects(EFFECTS)
        yield from self._try_bands(COUNTS)
        yield from self._refer(LATER_REFERENCE)
        yield from self._repeat(END)
        yield from self._refer(END)

    def _run(self, setting: Setting, share: float, *, base: bool = False) -> Iterator[Event]:
        """One run, unless it is too long."""
        guess = self.bench.guess(setting)
        if guess is not None and not self.budget.holds(guess, share):
            yield self._skip(setting, guess)
            return
        started = self.bench.start(setting)
        twin = self._same_elements(setting, started.plan)
        if twin is not None:
            bound = f": {started.plan.size_bound}" if started.plan.size_bound else ""
            yield self._skip(setting, None, f"makes the {twin} elements of normal{bound}")
            return
        if started.predicted is not None and not self.budget.holds(started.predicted, share):
            yield self._skip(setting, started.predicted)
            return
        run = self.bench.finish(started)
        self.runs.append(run)
        if base:
            self.bench.learn(run, started.plan)
        yield self._event(run)

    def _same_elements(self, setting: Setting, plan: Plan) -> int | None:
        """Elements of normal when a setting that asks for others makes as many."""
        usual = next((run for run in self.runs if run.setting.name == "normal"), None)
        if setting.group != "elements" or usual is None:
            return None
        same = abs(plan.n_elements / usual.elements - 1.0) < SAME_ELEMENTS
        return usual.elements if same else None

    def _sweep(self, settings: Sequence[Setting], share: float) -> Iterator[Event]:
        """All of them, the cheapest first; those of which nothing is known come after the others of their kind."""
        pending = list(settings)
        while pending:
            guesses = [self.bench.guess(setting) for setting in pending]
            known = [(guess, k) for k, guess in enumerate(guesses) if guess is not None]
            unknown = [k for k, guess in enumerate(guesses) if guess is None]
            affordable = bool(known) and self.budget.holds(min(known)[0], share)
            chosen = min(known)[1] if affordable or not unknown else unknown[0]
            yield from self._run(pending.pop(chosen), share)

    def _refer(self, share: float) -> Iterator[Event]:
        """Let the reference go on until it is good enough or a share of the budget is spent."""
        while self.budget.left(share) > 0.0 and self.bench.reference.noise() > NOISE_GOAL * self._best_error():
            if not self.bench.reference.advance(self.budget.left(share)):
                break
        noise = self.bench.reference.noise()
        yield Event("reference", {"paths": self.bench.reference.paths, "noise": noise, "spent": self.budget.spent})

    def _best_error(self) -> float:
        return min((price.illuminance.rms for price in self.prices()), default=0.0) if self.runs else 0.0

    def _combine(self, share: float) -> Iterator[Event]:
        """Combinations that the single changes let hope for."""
        usual = next((price for price in self.prices() if price.setting.name == "normal"), None)
        if usual is None:
            return
        changes: dict[str, list[Change]] = {}
        words = {word: name for name, word in KNOBS.items()}
        for price in self.prices():
            name = words.get(price.setting.group)
            if name is None:
                continue
            factor = getattr(price.setting.options, name) / getattr(usual.setting.options, name)
            square = price.illuminance.rms**2 - usual.illuminance.rms**2
            change = Change(factor, price.cpu_seconds - usual.cpu_seconds, square)
            changes.setdefault(name, []).append(change)
        found = propose(usual.cpu_seconds, usual.illuminance.rms, changes, most=MOST_COMBINATIONS)
        for proposal in found:
            setting = combined(dict(proposal.factors))
            guess = self.bench.guess(setting)
            if guess is not None and self.budget.holds(guess, share):
                yield from self._run(setting, share)

    def _try_solvers(self, share: float) -> Iterator[Event]:
        """Each solver on draft's elements."""
        for name in SOLVERS:
            setting = for_solver(name)
            guess = self.bench.guess(setting)
            if guess is not None and not self.budget.holds(guess, share):
                yield self._skip(setting, guess)
                continue
            try:
                started = self.bench.start(setting)
            except SceneError as error:
                yield self._skip(setting, None, f"too many elements: {error.faults[0].found}")
                continue
            seconds = self._solver_seconds(name, started.plan)
            if not self.budget.holds(seconds, share):
                yield self._skip(setting, seconds)
                continue
            run = self.bench.finish(started)
            found = run.convergence
            if not found:
                return
            price = SolverPrice(name, run.elements, found["seconds"], found["products"], found["residual"][-1])
            self._solve_seconds = price.cpu_seconds if name == "cg" else self._solve_seconds
            self.solvers.append(price)
            yield Event("solver", price.__dict__ | {"spent": self.budget.spent})

    def _solver_seconds(self, name: str, plan: Plan) -> float:
        """Wall seconds of two replicates, about."""
        if name in SLOWER_THAN_CG:
            return 2.0 * SLOWER_THAN_CG[name] * self._solve_seconds
        if name == "cg":
            return 0.0
        return 2.0 * DENSE_SECONDS * (plan.n_elements / DENSE_ELEMENTS) ** 3 * plan.columns.n_columns / DENSE_COLUMNS

    def _try_effects(self, share: float) -> Iterator[Event]:
        """Each effect that may be forced, at the best quality that the time allows."""
        usual = next((run for run in reversed(self.runs) if run.setting.name in ("draft", "normal")), None)
        if usual is None:
            return
        if not self.budget.holds(len(FORCED) * usual.wall_seconds, share):
            usual = next(run for run in self.runs if run.setting.group == "quality")
        for name, flags, change in FORCED:
            setting = Setting(name, "effect", forced(usual.setting.options, change))
            if not self.budget.holds(usual.wall_seconds, share):
                yield self._skip(setting, usual.wall_seconds)
                continue
            price = effect_price(name, flags, usual, self.bench.finish(self.bench.start(setting)))
            self.effects.append(price)
            yield Event("effect", price.__dict__ | {"spent": self.budget.spent})

    def _try_bands(self, share: float) -> Iterator[Event]:
        """The scene in other bands."""
        draft = next((run for run in self.runs if run.setting.name == "draft"), None)
        if draft is None or self._in_bands is None:
            return
        per_column = draft.wall_seconds
        for count in BANDS:
            setting = for_bands(count)
            if not self.budget.holds(per_column, share):
                yield self._skip(setting, per_column)
                continue
            try:
                scene = self._in_bands(count)
            except SceneError as error:
                yield self._skip(setting, None, error.faults[0].found)
                continue
            started = self.bench.start(setting, scene=scene)
            before = self.budget.spent
            run = self.bench.finish(started)
            columns = started.plan.columns.n_columns
            self._bands.append((count, columns, run))
            longer = BANDS[min(BANDS.index(count) + 1, len(BANDS) - 1)] / count
            per_column = max(self.budget.spent - before, draft.wall_seconds) * max(longer / 2.0, 1.0)
            values = {"bands": count, "columns": columns, "cpu_seconds": run.cpu_seconds}
            yield Event("bands", values | {"spent": self.budget.spent})

    def _repeat(self, share: float) -> Iterator[Event]:
        """Further seeds, for what is on the front first, then for all that there is time for."""
        for seed in range(1, SEEDS):
            found = sorted(self.prices(), key=lambda price: (not price.on_front, price.cpu_seconds))
            for price in found:
                if self.budget.holds(price.wall_seconds, share):
                    run = self.bench.finish(self.bench.start(price.setting, seed))
                    self.runs.append(run)
                    yield self._event(run)

    def _skip(self, setting: Setting, predicted: float | None, reason: str = "over the budget") -> Event:
        skipped = Skipped(setting.name, setting.group, predicted, reason)
        self.skipped.append(skipped)
        return Event("skipped", skipped.__dict__ | {"spent": self.budget.spent})

    def _event(self, run: Run) -> Event:
        """A run, with its error so far if there is a reference already."""
        values: dict[str, Any] = {
            "setting": run.setting.name,
            "seed": run.seed,
            "elements": run.elements,
            "cpu_seconds": run.cpu_seconds,
            "wall_seconds": run.wall_seconds,
            "spent": self.budget.spent,
        }
        if self.bench.reference.paths:
            price = next(p for p in self.prices() if p.setting.name == run.setting.name)
            values["illuminance_rms"] = price.illuminance.rms
        return Event("run", values)
