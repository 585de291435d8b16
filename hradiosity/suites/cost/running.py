"""Measures a scene within a budget: qualities, single knobs, combinations, solvers, effects, bands, other seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

from hradiosity.errors import SceneError
from hradiosity.model.scene import Scene
from hradiosity.plan import Plan
from hradiosity.suites.cost.budget import Budget
from hradiosity.suites.cost.combine import Change, propose
from hradiosity.suites.cost.extras import OVER, Extras
from hradiosity.suites.cost.pricing import Truth, prices
from hradiosity.suites.cost.protocols import Bench, Event
from hradiosity.suites.cost.settings import KNOBS, Setting, classic, combined, methods, qualities, single_knobs, warm_up
from hradiosity.suites.cost.values import Price, Run, Skipped

FIRST_REFERENCE: Final = 0.18
SWEEP, COMBINATIONS, OTHER_METHODS = 0.36, 0.42, 0.54
SOLVING, EFFECTS, COUNTS = 0.58, 0.63, 0.70
AGAIN, LATER_REFERENCE = 0.70, 0.86
END: Final = 0.95
"""Shares of the budget after which each part ends, in their order; what one leaves over is the next one's, and then
that of all settings that were too long for their part, the cheapest first. The last twentieth is for writing."""
WORST: Final = 0.3
"""The reference is never worse than is good for such an error."""
FINE: Final = 0.12
"""The quality fine does not wait for its turn if it takes no more than this share."""
NOISE_GOAL: Final = 1.0 / 3.0
"""The reference is good enough when its noise is below this share of the best setting's error."""
MOST_COMBINATIONS: Final = 6
SEEDS: Final = 3
SAME_ELEMENTS: Final = 0.02
"""Two cuts whose numbers of elements differ by less are one."""


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
        self.bench = bench
        self.budget = Budget(seconds, bench.clock)
        self.runs: list[Run] = []
        self.skipped: list[Skipped] = []
        self._later: list[Setting] = []
        self.extras = Extras(bench, self.budget, self._skip, in_bands)

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
        yield from self._run(normal, OTHER_METHODS, base=True)
        guess = self.bench.guess(fine)
        at_once = guess is not None and guess <= FINE * self.budget.seconds
        if at_once:
            yield from self._run(fine, SWEEP)
        yield from self._refer(FIRST_REFERENCE)
        yield from self._sweep([*([] if at_once else [fine]), *single_knobs()], SWEEP)
        yield from self._combine(COMBINATIONS)
        yield from self._sweep([*methods(), *classic()], OTHER_METHODS)
        if not any(setting.group == "quality" and setting.name != fine.name for setting in self._later):
            yield from self.extras.try_solvers(SOLVING)
            yield from self.extras.try_effects(self.runs, EFFECTS)
            yield from self.extras.try_bands(self.runs, COUNTS)
        yield from self._sweep(self._later, AGAIN, last=True)
        yield from self._refer(LATER_REFERENCE)
        yield from self._repeat(END)
        yield from self._refer(END)

    def _run(self, setting: Setting, share: float, *, base: bool = False, last: bool = False) -> Iterator[Event]:
        """One run; if it is too long it is left for later, or out if this is the last chance."""
        guess = self.bench.guess(setting)
        if guess is not None and not self.budget.holds(guess, share):
            yield from self._put_off(setting, guess, last=last)
            return
        try:
            started = self.bench.start(setting)
        except SceneError as error:
            paired = setting.group == "form factors"
            reason = "too many elements to hold all pairs" if paired else f"refused: {error.faults[0].found}"
            yield self._skip(setting, None, reason)
            return
        twin = self._same_elements(setting, started.plan)
        if twin is not None:
            bound = f": {started.plan.size_bound}" if started.plan.size_bound else ""
            yield self._skip(setting, None, f"the {twin.elements} elements of {twin.setting.name} again{bound}")
            return
        if started.predicted is not None and not self.budget.holds(started.predicted, share):
            yield from self._put_off(setting, started.predicted, last=last)
            return
        run = self.bench.finish(started)
        self.runs.append(run)
        if base:
            self.bench.learn(run, started.plan)
        yield self._event(run)

    def _same_elements(self, setting: Setting, plan: Plan) -> Run | None:
        """The run that made as many elements, when a setting asks for others and can't have them."""
        if setting.group != "elements":
            return None
        alike = [run for run in self.runs if run.setting.group == "elements" or run.setting.name == "normal"]
        return next((run for run in alike if abs(plan.n_elements / run.elements - 1.0) < SAME_ELEMENTS), None)

    def _put_off(self, setting: Setting, predicted: float, *, last: bool) -> Iterator[Event]:
        """Leave a setting for later; told if there is none."""
        if last:
            yield self._skip(setting, predicted)
        else:
            self._later.append(setting)

    def _sweep(self, settings: Sequence[Setting], share: float, *, last: bool = False) -> Iterator[Event]:
        """All of them, the cheapest first; those of which nothing is known come after the others of their kind."""
        pending = list(settings)
        while pending:
            guesses = [self.bench.guess(setting) for setting in pending]
            known = [(guess, k) for k, guess in enumerate(guesses) if guess is not None]
            unknown = [k for k, guess in enumerate(guesses) if guess is None]
            affordable = bool(known) and self.budget.holds(min(known)[0], share)
            chosen = min(known)[1] if affordable or not unknown else unknown[0]
            yield from self._run(pending.pop(chosen), share, last=last)

    def _refer(self, share: float) -> Iterator[Event]:
        """Let the reference go on until it is good enough or a share of the budget is spent."""
        while self.budget.left(share) > 0.0 and self.bench.reference.noise() > NOISE_GOAL * self._best_error():
            if not self.bench.reference.advance(self.budget.left(share)):
                break
        noise = self.bench.reference.noise()
        yield Event("reference", {"paths": self.bench.reference.paths, "noise": noise, "spent": self.budget.spent})

    def _best_error(self) -> float:
        """Of all settings, or what their replicates promise if that is less: a bad reference makes all look bad."""
        found = self.prices() if self.runs else []
        return min((min(price.illuminance.rms, price.sampling, WORST) for price in found), default=0.0)

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

    def _repeat(self, share: float) -> Iterator[Event]:
        """Further seeds, for what is on the front first, then for all that there is time for."""
        for seed in range(1, SEEDS):
            found = sorted(self.prices(), key=lambda price: (not price.on_front, price.cpu_seconds))
            for price in found:
                if self.budget.holds(price.wall_seconds, share):
                    run = self.bench.finish(self.bench.start(price.setting, seed))
                    self.runs.append(run)
                    yield self._event(run)

    def _skip(self, setting: Setting, predicted: float | None, reason: str = OVER) -> Event:
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
