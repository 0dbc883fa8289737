"""The one palette of pictures and pages: Okabe & Ito (2008), which people with colour-vision deficiency tell apart."""

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILION, PURPLE = "#0072B2", "#D55E00", "#CC79A7"
INK, MUTED, FAINT, GROUND = "#222222", "#6B6B6B", "#DDDDDD", "#EFEBE4"

#: Warm regimes cost energy, cool ones do not.
REGIME_COLORS = {"traction": VERMILION, "cruising": ORANGE, "coasting": GREEN, "braking": BLUE}

#: Colours of a page by their role, on light paper and on dark: there the dark ones of the palette are lifted, so that
#: each keeps its hue and a contrast of at least 3 against the ground, text of at least 4.5 (WCAG 2.2).
LIGHT = {
    "paper": "#FFFFFF", "ground": "#F6F4F0", "raised": "#FFFFFF", "ink": INK, "muted": "#5C5C5C", "line": "#D5D1C9",
    "grid": "#E7E4DD", "terrain": "#DDD5C5", "accent": BLUE, "on-accent": "#FFFFFF", "error": "#B3261E",
    "fastest": VERMILION, "front": BLUE, "pin-a": "#7A3E9D", "pin-b": "#00695C", "limit": MUTED, "bound": SKY,
    "neutral": PURPLE, "stops": INK, "lowered": PURPLE, "tunnels": MUTED, "curves": SKY, **REGIME_COLORS,
}  # fmt: skip
DARK = LIGHT | {
    "paper": "#16191D", "ground": "#0F1114", "raised": "#1E2227", "ink": "#ECEAE6", "muted": "#A9ABAE",
    "line": "#3A3F45", "grid": "#2A2E33", "terrain": "#3B372F", "accent": "#5AB0E8", "on-accent": "#0B0D0F",
    "error": "#FF8A80", "fastest": "#FF7A3D", "front": "#5AB0E8", "pin-a": "#D0A3EE", "pin-b": "#63D2C3",
    "limit": "#A9ABAE", "stops": "#ECEAE6", "tunnels": "#A9ABAE", "traction": "#FF7A3D", "cruising": "#F2B33D",
    "coasting": "#2CC79A", "braking": "#4FA8E8",
}  # fmt: skip
