"""Searches for the front of delay against energy: best-first and exact on a grid, and the continuous front."""
