"""The small explicit graph that searches run on, as CSR arrays, and its networkx view, for drawing and testing."""
