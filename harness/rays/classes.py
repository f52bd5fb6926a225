"""The classes of rays that are replayed, and what is asked of each."""

CLASSES: dict[str, bool] = {
    "camera": False,
    "shadow": True,
    "ambient": True,
    "diffuse1": False,
    "diffuse2": False,
    "shuffled": False,
    "random": False,
    "random_any": True,
}
"""Name of a class to whether any hit will do; else the closest one is wanted."""
