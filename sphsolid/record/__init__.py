"""What a run hands out: snapshots, histories, norms."""

from sphsolid.record.budget import Budget, NotTracked
from sphsolid.record.budget_recorders import EnergyBudget, MomentumDrift, Reactions
from sphsolid.record.checkpoint import restore, write_checkpoint
from sphsolid.record.history import History, read_history
from sphsolid.record.march import march
from sphsolid.record.norms import instant_errors, l2_norm, period_errors
from sphsolid.record.output import Every, Never, NoOutput, Output
from sphsolid.record.placement import NoSecondaryGradient, Placement, SecondaryGradient
from sphsolid.record.positions import (
    Positions,
    PositionVerdict,
    PositionWatch,
    judge_positions,
)
from sphsolid.record.progress import Progress, ProgressLine
from sphsolid.record.recorders import (
    AngularMomentum,
    Energy,
    Errors,
    LinearMomentum,
    Probe,
    Recorder,
    angular_momentum,
    linear_momentum,
)
from sphsolid.record.recovery import Recovery
from sphsolid.record.run_folder import RunFolder
from sphsolid.record.run_json import read_run
from sphsolid.record.snapshot import PointField, Snapshot
from sphsolid.record.solver import Solver
from sphsolid.record.turned_cells import InsideOut, inside_out, inside_out_secondary
from sphsolid.record.unseen_pairs import UnseenMotion, unseen_motion
from sphsolid.record.vtu import write_vtu

__all__ = [
    "AngularMomentum",
    "Budget",
    "Energy",
    "EnergyBudget",
    "Errors",
    "Every",
    "History",
    "InsideOut",
    "LinearMomentum",
    "MomentumDrift",
    "Never",
    "NoOutput",
    "NoSecondaryGradient",
    "NotTracked",
    "Output",
    "Placement",
    "PointField",
    "PositionVerdict",
    "PositionWatch",
    "Positions",
    "Probe",
    "Progress",
    "ProgressLine",
    "Reactions",
    "Recorder",
    "Recovery",
    "RunFolder",
    "SecondaryGradient",
    "Snapshot",
    "Solver",
    "UnseenMotion",
    "angular_momentum",
    "inside_out",
    "inside_out_secondary",
    "instant_errors",
    "judge_positions",
    "l2_norm",
    "linear_momentum",
    "march",
    "period_errors",
    "read_history",
    "read_run",
    "restore",
    "unseen_motion",
    "write_checkpoint",
    "write_vtu",
]
