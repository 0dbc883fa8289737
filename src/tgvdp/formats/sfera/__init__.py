"""SFERA (UIC IRS 90940), what driver advisory systems are told: journeys over segments as lines, timetables, trains."""
