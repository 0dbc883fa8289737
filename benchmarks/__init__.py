"""Benchmarks of tgvdp: ``python -m benchmarks`` runs them all; docs/benchmarks.md says what they measure and how."""
