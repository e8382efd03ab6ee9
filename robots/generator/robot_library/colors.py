"""Colours that robots share, by the name of their material: red, green and blue, 0 to 1."""

COLORS = {
    "white": (0.90, 0.90, 0.89),
    "silver": (0.76, 0.77, 0.79),
    "gray": (0.62, 0.635, 0.65),
    "dark": (0.16, 0.165, 0.175),
    "black": (0.075, 0.078, 0.085),
    "metal": (0.46, 0.47, 0.49),
    "blue": (0.45, 0.64, 0.78),
    "orange": (0.93, 0.45, 0.10),
    "red": (0.62, 0.09, 0.10),
    "yellow": (0.96, 0.76, 0.16),
    "pad": (0.80, 0.80, 0.77),
}
