"""Partial derivatives of free rotation by its initial state and inertia (docs/partial-derivatives.md)."""
