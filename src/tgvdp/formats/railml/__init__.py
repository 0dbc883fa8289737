"""railML 2.2 to 2.5 and 3.1 to 3.2: the infrastructure that one run needs, and rolling stock. Start at `reader`."""
