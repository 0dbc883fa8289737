"""The problem itself: `instances` and their `reading`, the `binary` and the `demand` model on the curves of `alstom`,
several trains at a `substation`, `three_phase` in closed form.

`schedule` is what all solvers hand over, `levels` the ladder that exact solvers walk, `replay` (and `demand_replay`)
what a schedule really does: it trusts nothing but the controls. This room knows nothing of QUBOs and programs. Start
reading at `instances`.
"""
