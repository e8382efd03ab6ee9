"""Names of the formats; the registry in `taskbuilder.data.formats` takes longer to load."""

FORMAT_NAMES = ("lerobot", "robomimic", "minari")
"""The library's own formats; installed packages may add others."""
