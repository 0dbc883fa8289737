"""The line as a trip sees it: cells of uniform gradient, limit and drag, stations, and the fastest run."""
