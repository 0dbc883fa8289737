"""Clean extremals: a run as a short list of commands, and the multiplier's exact switches (docs/extremals.md).

A command says from where on the train pulls, coasts or brakes by its dynamic brake; holding and riding the envelope
follow by geometry (`simulate`). One backward `sweep` yields costate, slope and tangent flow, and with them Newton's
step in all switches at once, and to the next running time (`newton`); `pins` hold where a run touches the envelope.

Invariants: every list of commands drives to a feasible run; at a multiplier a step is kept only where E + λT falls.
"""
