"""What a file holds, in `figures`: those that an engineer checks first (`describe`), those that are unusual
(`plausibility`), and where in the file they stand (`places`).
"""
