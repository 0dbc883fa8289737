"""The seeds' formulations as values and functions, from the instance to the circuit, without any quantum package."""
