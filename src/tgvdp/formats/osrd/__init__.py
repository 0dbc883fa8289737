"""OSRD: rolling stock as RailJSON, in SI units. Start at `stock`."""
