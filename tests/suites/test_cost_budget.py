"""What the cost suite runs within a budget: forecasts, order and omissions, by a clock that is set."""

import math
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from cost_runs import N, readings_of, run_of

from hradiosity.errors import SceneError
from hradiosity.options import Options
from hradiosity.suites.cost import running
from hradiosity.suites.cost.budget import Budget
from hradiosity.suites.cost.running import CostRun
from hradiosity.suites.cost.settings import classic, methods, qualities, single_knobs
from hradiosity.suites.cost.work import Measured, predict, work_of


def test_prediction_scales_stages():
    sizes = {"n_readings": 100, "n_emitters": 2, "columns": 10}
    usual = work_of(4000, Options(), **sizes)
    stages = {"exchange rays": 1.0, "readings": 2.0}
    base = Measured(4.0, stages, usual)
    assert predict(base, usual) == pytest.approx(4.0)
    more = work_of(4000, Options(rays_per_element=2 * Options.rays_per_element), **sizes)
    assert predict(base, more) == pytest.approx(5.0)
    light = work_of(4000, Options(light_samples=1, gather_samples=8), **sizes)
    assert predict(base, light) == pytest.approx(2.0, abs=0.02)


def test_two_runs_tell_what_a_stage_takes_anyway():
    """2 s at 10 units and 1 s at 5: 3 s at 15. 2 s and 1.4 s: 2.6 s. With work alike there is no line."""
    base = Measured(5.0, {"readings": 2.0}, {"readings": 10.0})
    for seconds, expected in ((1.0, 6.0), (1.4, 5.6), (2.5, 5.3), (0.1, 6.0)):
        smaller = Measured(1.0, {"readings": seconds}, {"readings": 5.0})
        assert predict(base, {"readings": 15.0}, smaller) == pytest.approx(expected)
    alike = Measured(1.0, {"readings": 1.9}, {"readings": 9.0})
    assert predict(base, {"readings": 15.0}, alike) == pytest.approx(6.0)


def test_budget_keeps_a_margin():
    now = [10.0]
    budget = Budget(100.0, clock=lambda: now[0])
    assert budget.holds(80.0) and not budget.holds(81.0)
    now[0] = 60.0
    assert budget.left() == 50.0 and budget.left(0.5) == 0.0 and not budget.holds(1.0, 0.5)


@dataclass
class FakeReference:
    """Noise falls with the root of the paths; a round takes a second."""

    bench: "FakeBench"
    paths: int = 0

    def advance(self, seconds):
        if self.paths and seconds < 1.0:
            return False
        self.bench.now += 1.0
        self.paths += 100
        return True

    def noise(self):
        return 0.1 / math.sqrt(self.paths) if self.paths else math.inf

    def readings(self):
        if not self.paths:
            raise RuntimeError("no path was traced yet")
        return readings_of(np.ones(N), spread=2.0 * self.noise())


class FakeBench:
    """A machine whose runs take what their samples say, times `slower` than it predicts."""

    def __init__(self, slower=1.0):
        self.now, self.slower, self.started = 0.0, slower, []
        self.reference = FakeReference(self)

    def clock(self):
        return self.now

    def _seconds(self, setting):
        options = setting.options
        if options.mode == "classic":
            return 0.05 * options.hemicube_resolution
        usual = Options()
        return 0.2 + options.elements / usual.elements / 2 + options.gather_samples / usual.gather_samples / 2

    def guess(self, setting):
        return self._seconds(setting)

    def start(self, setting, seed=0, scene=None):
        self.started.append((setting.name, seed))
        columns = SimpleNamespace(n_columns=8)
        plan = SimpleNamespace(n_elements=setting.options.elements, size_bound="", columns=columns)
        return SimpleNamespace(setting=setting, seed=seed, plan=plan, predicted=self._seconds(setting))

    def finish(self, started):
        seconds = self._seconds(started.setting)
        self.now += self.slower * seconds
        lux = 1.0 + 0.01 / math.sqrt(seconds) * np.cos(np.arange(N) + started.seed)
        run = run_of(started.setting, lux, seconds, seed=started.seed, elements=started.setting.options.elements)
        convergence = {"seconds": 0.01, "products": 7.0, "residual": (1.0, 1e-4)}
        return replace(run, convergence=convergence)

    def learn(self, run, plan):
        pass


@pytest.mark.parametrize("budget", [20.0, 120.0])
@pytest.mark.parametrize("slower", [0.8, 1.0, 1.2])
def test_the_budget_is_kept(budget, slower):
    bench = FakeBench(slower)
    run = CostRun(bench, budget, in_bands=lambda count: None)
    events = list(run.events())
    assert bench.now <= 1.0 * budget
    assert bench.now >= 0.8 * budget or all(r.seed == running.SEEDS - 1 for r in run.runs[-3:])
    told = {(s.name, s.group) for s in run.skipped} | {(r.setting.name, r.setting.group) for r in run.runs}
    for setting in (*qualities(), *single_knobs(), *methods(), *classic()):
        assert (setting.name, setting.group) in told
    assert [e.kind for e in events].count("skipped") == len(run.skipped)
    assert all(item.predicted is not None for item in run.skipped)


def test_settings_come_by_rising_cost():
    bench = FakeBench()
    run = CostRun(bench, 60.0)
    list(run.events())
    knobs = {setting.name for setting in single_knobs()}
    swept = [r for r in run.runs if r.seed == 0 and r.setting.name in knobs]
    seconds = [r.cpu_seconds for r in swept]
    assert seconds == sorted(seconds) and len(seconds) > 8


def test_what_was_too_long_for_its_part_comes_with_what_is_left():
    """Nothing but the sweep fits before its share ends; what solvers, effects and bands leave over is for the rest."""
    bench = FakeBench()
    run = CostRun(bench, 14.0)
    list(run.events())
    names = {r.setting.name for r in run.runs}
    assert {"draft", "normal", "elements × 0.25"} <= names and len(names) >= 6
    assert not names & {item.name for item in run.skipped}


def test_what_is_known_can_be_asked_for_early():
    run = CostRun(FakeBench(), 60.0)
    events = run.events()
    while len(run.runs) < 3:
        next(events)
    assert len(run.prices()) == 3


def test_elements_that_are_no_others_are_skipped():
    bench = FakeBench()
    start = bench.start

    def bounded(setting, seed=0, scene=None):
        started = start(setting, seed, scene)
        started.plan.n_elements, started.plan.size_bound = Options.elements, "cells no smaller"
        return started

    bench.start = bounded
    run = CostRun(bench, 200.0)
    list(run.events())
    found = {item.name: item.reason for item in run.skipped if item.group == "elements"}
    assert found["elements × 2"] == f"the {Options.elements} elements of normal again: cells no smaller"


def test_solvers_that_are_refused_are_told():
    from hradiosity.errors import Fault

    bench = FakeBench()
    start = bench.start

    def refusing(setting, seed=0, scene=None):
        if setting.name == "block-inversion":
            raise SceneError([Fault("command line", "", "9000 elements", "fewer")])
        return start(setting, seed, scene)

    bench.start = refusing
    run = CostRun(bench, 120.0)
    list(run.events())
    assert "cg" in {s.name for s in run.extras.solvers}
    assert [s.reason for s in run.skipped if s.name == "block-inversion"] == ["too many elements: 9000 elements"]
