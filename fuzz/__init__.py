"""Slips of unit and mutated files through load, search, replay, proof and writing: ``python -m fuzz`` (docs/trust.md).

Each case is one command line, run by a child that is forked from a process with all kernels loaded, so that it starts
within milliseconds, as it would run by itself: what counts is its exit code, what it prints, how long it takes and how
much memory. A case fails by a signal, a traceback, a raw warning, an error of several lines, a number that is none in a
file, time beyond its limit, or memory.
"""
