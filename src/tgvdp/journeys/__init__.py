"""Journeys: a train over several stops, and how its running-time supplement is best split among the sections.

Knows the runs of each section between two stops (`section`); the exact merge of the sections' fronts on common steps
of time, convex or not (`merge`); what each section gets when all run at one multiplier (`multiplier`); how timetables
split the supplement today (`practices`); and the journey's front from all of these (`front`). With windows
(`windows`) the front is that of arrivals (`timed`): parts that end at stops and where the train passes are planned
(`timetable`, `speeds`), and sections solved in one piece with a multiplier for each timing point (`whole`, `passed`).
`bound` and `timed_bound` certify a journey without and with windows; `delays` simulates it when it is late.

Invariants: no allocation is later than asked; no point of the front is dearer than a practice at its time; nothing
here solves a section itself, a method is handed in. Start reading at `front`.
"""
