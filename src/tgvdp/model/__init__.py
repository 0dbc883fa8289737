"""What the problem is: frozen, self-validating descriptions in SI units; no files, no algorithms."""
