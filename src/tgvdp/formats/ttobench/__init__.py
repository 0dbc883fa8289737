"""TTOBench JSON: tracks, trains and journeys (library versions 1.1 to 1.5; Kouzoupis et al.). Start at `reader`."""
