"""What a run hands out: snapshots, histories, norms."""

from sphsolid.record.balance import Balance, NotTracked
from sphsolid.record.ledger import EnergyLedger, MomentumDrift, Reactions
from sphsolid.record.march import History, Progress, march
from sphsolid.record.norms import instant_errors, l2_norm, period_errors
from sphsolid.record.recorders import (
    AngularMomentum,
    Energy,
    Errors,
    LinearMomentum,
    Probe,
    angular_momentum,
    linear_momentum,
)
from sphsolid.record.snapshot import PointField, Snapshot

__all__ = [
    "AngularMomentum",
    "Balance",
    "Energy",
    "EnergyLedger",
    "Errors",
    "History",
    "LinearMomentum",
    "MomentumDrift",
    "NotTracked",
    "PointField",
    "Probe",
    "Progress",
    "Reactions",
    "Snapshot",
    "angular_momentum",
    "instant_errors",
    "l2_norm",
    "linear_momentum",
    "march",
    "period_errors",
]
