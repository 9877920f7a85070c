"""What a run hands out: snapshots, histories, norms."""

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
    "Energy",
    "Errors",
    "History",
    "LinearMomentum",
    "PointField",
    "Probe",
    "Progress",
    "Snapshot",
    "angular_momentum",
    "instant_errors",
    "l2_norm",
    "linear_momentum",
    "march",
    "period_errors",
]
