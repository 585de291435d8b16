"""The whole computation: replicates of transport, solution and readings, one after the other."""

from hradiosity.radiosity.solver import RadiositySolver, State, solve

__all__ = ["RadiositySolver", "State", "solve"]
