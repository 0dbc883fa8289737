"""tgvdp's own format: a train, a track, an energy map and run options as TOML tables, or the same structure as JSON.

`specs` declares all fields with units and ranges, `reader` and `write` turn them into the model and back. Start at
`specs`.
"""
