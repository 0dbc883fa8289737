"""railtoolkit YAML or JSON: running paths and rolling stock, as TrainRuns.jl reads them. Start at `reader`."""
