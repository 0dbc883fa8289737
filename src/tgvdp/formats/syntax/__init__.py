"""Texts as trees: JSON, TOML, YAML and XML from strangers, typed, with errors that name file, field and value.

Invariant: no room here knows what a train is. Start reading at `reading`, then `typed`.
"""
