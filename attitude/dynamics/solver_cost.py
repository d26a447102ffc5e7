"""Seconds that solutions take on one core, by which plans foretell their time; measured."""

# Of an instant: read off the polynomial of a step, reached by a step, within an arc between edges of plates.
DENSE_SAMPLE, SAMPLE, ARC_SAMPLE = 2.5e-7, 1.5e-6, 2.5e-6


def of_steps(steps: float, sweeps: float, effects: int) -> float:
    """A solution and the coarser one beside it, 1.5 ms to prepare them included; effects : their number."""
    return 1.5e-3 + 4e-7 * steps + sweeps * (1.5e-7 + 2.5e-8 * max(0, effects - 1))


def of_arcs(arcs: float, edges: int) -> float:
    """Two solutions in arcs between edges of plates, of which a turn has so many; 15 ms to prepare them."""
    return 1.5e-2 + arcs * (3.5e-6 + 2e-9 * edges)
