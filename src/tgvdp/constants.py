"""One place for physical constants and for the tolerances that every part shares."""

#: Gravity as TTOBench and OSRD use it, m/s².
GRAVITY_MPS2 = 9.81

#: Standard gravity (CGPM 1901), as railtoolkit uses it, m/s².
STANDARD_GRAVITY_MPS2 = 9.80665

#: Relative slack with which every kernel accepts a force, an acceleration or a speed limit.
FEASIBILITY_RTOL = 1e-9

#: Verdict of the replay referee: largest relative error of running time and energy, in percent. The front's runs are
#: right to a hundredth of that (tests/methods/costate), refined ones to half of it, energy by a map to two thirds.
REPLAY_TIME_PCT = 0.01
REPLAY_ENERGY_PCT = 0.05
#: ... largest excess of effort and acceleration over their limits, in percent.
REPLAY_EFFORT_PCT = 0.1
#: ... largest overspeed, relative to the largest speed of the run (floating-point noise only).
REPLAY_OVERSPEED_RTOL = 1e-6
#: ... largest difference between claimed and replayed speed, relative to the largest speed of the run.
REPLAY_SPEED_RTOL = 0.01

#: Names of the search methods and of the queue orders of best-first, as the command line and scenario files spell them.
METHODS = ("front", "exact", "best-first")
HEURISTICS = ("ratio", "time", "energy", "weighted")
#: Time limit of a search unless the caller says otherwise, s: a search always has a budget.
DEFAULT_TIME_S = 60.0

#: What can be minimised, spelled likewise (see `tgvdp.model.energy`).
ENERGY_KINDS = ("wheel", "pantograph", "map")
#: Names of the conventions and of their switches, spelled likewise (see `tgvdp.model.convention`).
CONVENTION_NAMES = ("ttobench", "osrd", "trainruns")
MASS_MODELS = ("point", "strip")
LIMIT_RULES = ("head", "tail")
CURVE_FORMULAS = ("none", "800/R", "roeckl")
