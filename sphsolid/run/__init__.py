"""What the simulations of both methods share: the run, its files, its copies, its budget."""

from sphsolid.run.base import BaseSimulation
from sphsolid.run.running_budget import NotOpened, RunningBudget, Works

__all__ = ["BaseSimulation", "NotOpened", "RunningBudget", "Works"]
