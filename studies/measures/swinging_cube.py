"""The swinging cube as all studies run it: two amplitudes, and errors over one period."""

from __future__ import annotations

from collections.abc import Iterator

from sphsolid.record import Snapshot, Solver, instant_errors, march, period_errors
from sphsolid.scenes import Scene, amplitude_of_gradient, swinging_cube

#: Instants of one period at which errors are taken: ``t_k = (k + 1/2) T / 12``.  Neither sine nor
#: cosine vanishes at any of them, so no instant hides the phase error or is nothing but it.
INSTANTS = 12
#: Amplitude [m] of the linear limit: nonlinear terms are 1e-7 of the linear ones.
LINEAR_AMPLITUDE = 1.0e-7
#: Largest principal value of the displacement gradient in the manufactured scene.
LARGEST_GRADIENT = 0.2
SCENES, FAMILIES = ("linear", "manufactured"), ("A+B+C=0", "A=B=C")
#: The same, begun at ``u = 0`` with all energy in the velocity: the first forces of a wave that
#: begins at full displacement have the whole error of a method at the boundary, and one without
#: damping carries it for ever.
MOVING = tuple(f"{scene}, moving start" for scene in SCENES)


def cube_scene(scene: str, family: str, **options: float) -> Scene:
    """The cube in the ``"linear"`` limit, or ``"manufactured"`` at the amplitude of the studies.

    ``scene`` is one of :data:`SCENES` or :data:`MOVING`.
    """
    manufactured = scene.startswith("manufactured")
    amplitude = (
        amplitude_of_gradient(family, LARGEST_GRADIENT)  # type: ignore[arg-type]
        if manufactured
        else LINEAR_AMPLITUDE
    )
    return swinging_cube(
        family=family,  # type: ignore[arg-type]
        amplitude=amplitude,
        manufactured=manufactured,
        start="moving" if scene in MOVING else "displaced",
        **options,  # type: ignore[arg-type]
    )


def instants_of(sim: Solver) -> Iterator[Snapshot]:
    """Run one period of a scene with an exact solution: what it is at the instants."""
    exact = sim.scene.known_solution()
    for k in range(INSTANTS):
        march(sim, until=(k + 0.5) * exact.period / INSTANTS)
        yield sim.snapshot()


def period_errors_of(sim: Solver) -> dict[str, float]:
    """Run one period of a scene with an exact solution; errors as :func:`period_errors` gives."""
    exact = sim.scene.known_solution()
    return period_errors(instant_errors(snapshot, exact) for snapshot in instants_of(sim))
