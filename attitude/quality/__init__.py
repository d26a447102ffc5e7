"""Judging files of attitudes: `check` one, `compare` two."""
