"""QAOA as a solver: `angles` on a statevector, and `qiskit` circuits on simulated noisy machines and on real ones."""
