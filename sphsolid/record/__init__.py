"""What a run hands out: snapshots, histories, norms."""

from sphsolid.record.balance import Balance, NotTracked
from sphsolid.record.checkpoint import restore, write_checkpoint
from sphsolid.record.history import History, read_history
from sphsolid.record.ledger import EnergyLedger, MomentumDrift, Reactions
from sphsolid.record.march import march
from sphsolid.record.norms import instant_errors, l2_norm, period_errors
from sphsolid.record.output import Every, Never, NoOutput, Output
from sphsolid.record.progress import Progress, ProgressLine
from sphsolid.record.recorders import (
    AngularMomentum,
    Energy,
    Errors,
    LinearMomentum,
    Probe,
    angular_momentum,
    linear_momentum,
)
from sphsolid.record.recovery import Recovery
from sphsolid.record.run_folder import RunFolder
from sphsolid.record.run_json import read_run
from sphsolid.record.snapshot import PointField, Snapshot
from sphsolid.record.solver import Solver
from sphsolid.record.vtu import write_vtu

__all__ = [
    "AngularMomentum",
    "Balance",
    "Energy",
    "EnergyLedger",
    "Errors",
    "Every",
    "History",
    "LinearMomentum",
    "MomentumDrift",
    "Never",
    "NoOutput",
    "NotTracked",
    "Output",
    "PointField",
    "Probe",
    "Progress",
    "ProgressLine",
    "Reactions",
    "Recovery",
    "RunFolder",
    "Snapshot",
    "Solver",
    "angular_momentum",
    "instant_errors",
    "l2_norm",
    "linear_momentum",
    "march",
    "period_errors",
    "read_history",
    "read_run",
    "restore",
    "write_checkpoint",
    "write_vtu",
]
