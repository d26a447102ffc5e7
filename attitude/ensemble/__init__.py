"""Ensembles: many bodies at many instants, on one machine or on many (docs/ensembles.md)."""
