"""Forces on a train, and what one stretch of constant acceleration or of one regime does. Kernels, in SI.

Knows forces at a speed and their means (`forces`), ONE arc function, two speeds and a length → feasible?, duration,
work (`arc`), motion under full traction, coasting and full braking at a speed (`motion`) and through a cell (`march`),
and what an arc is charged for (`energy`). For the kernels of all rooms: uniform cells and rows (`cell`), the numbers
of regimes and of what kernels return (`codes`), and the bracket of a root (`roots`).

Invariants: the state is w = v², linear in the position along a row of constant acceleration, so that duration and
work are in closed form, also from standstill; kernels make no arrays. Start reading at `arc`.
"""
