"""What is known of each switch between two commands of a run: columns of a table that `sweep` fills."""

#: Columns of what a sweep says of a command: derivative g of the cost by its position while the switches after it take
#: their steps, its derivative A (its size where it is not positive), that by the squared speed B, the jump of effort Δ,
#: σ = g/Δ, the flow from the active switch before it, whether it is active (−1: and A is not positive), the derivative
#: of the cost while all other switches stay, that of g by the multiplier, that of the running time, and what the
#: multiplier adds to the squared speed at a switch that leaves a hold.
GAIN, CURVATURE, CROSS, JUMP, SIGMA, FLOW, ACTIVE, SLOPE, BY_MULTIPLIER, OF_TIME, HELD_W = range(11)
SWITCH_COLUMNS = 11
#: How a switch may be bound: to where its run touches the envelope, to a corner of the envelope, or to where it is.
PINNED = 1
FIXED = 2
FROZEN = 3
