"""The data of an ephemeris: chunks, events, translation, provenance, and rotation to another frame."""
