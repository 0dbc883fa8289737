"""QAOA: angles, gates and OpenQASM as plain data (`qaoa`), and its exact simulation (`statevector`)."""
