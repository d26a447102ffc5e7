"""Partial derivatives of free rotation by its initial state and inertia (docs/theory.md, section 12)."""
