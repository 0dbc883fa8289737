"""Benchmarks of tgvdp: ``python -m benchmarks`` runs them all; docs/speed.md says what they measure and how."""
