"""Numbers with names: the regimes of driving, and what kernels return. One numbering for all rooms.

Plain integers: an `enum.IntEnum` is a type of its own to numba, which would compile each kernel once more for it.
"""

#: Regimes. Along a run only the first four can be told apart (`runs.profile.REGIMES`); the certificate knows all.
TRACTION = 0  # full
HOLDING = 1  # partial traction: a speed is kept
COASTING = 2
BRAKING = 3  # all brakes, in full
DYNAMIC = 4  # the whole dynamic brake, alone
RETARDED = 5  # partial effort of the dynamic brake
HELD_BACK = 6  # the whole dynamic brake and partial friction
DYNAMIC_BRAKING = 7  # full braking that is all done by the dynamic brake

#: What kernels return; 0 is success everywhere. The first limit that an arc breaks:
OK = 0
OVER_TRACTION = 1
OVER_BRAKE = 2
OVER_ACCELERATION = 3
OVER_DECELERATION = 4
STANDSTILL = 5
OVER_EFFORT_AT_POINT = 6
OVER_LIMIT = 7
#: ... why a run ends early:
NO_ROOM = 8  # the row buffers are too small
NO_BRAKE = 9  # no speed at this station lets the train obey what comes after
TOO_FAST = 10  # the start speed is too high for what comes after it
STALLED = 11  # full traction does not carry the train over this cell
#: ... and why a method looks again:
CROWDED = 12  # too many points of the costate polyline
NOT_MET = 13  # no blend takes the time: it jumps
NOT_KEPT = 14  # the blend costs other than the cubic promises
NOT_TRIED = 15  # an earlier time between the same extremals was not kept
