"""What a file holds, in the figures that an engineer checks first (`describe`), what is unusual in it
(`plausibility`), and where in the file that stands (`places`).
"""
