"""An edge, and what is one: a line that is set to the level it has does not move."""
from typing import NamedTuple

# As a rig stands before a burst. The analyser may stand either way: its first setting is an edge.
START_LEVELS = {"BLANK": 1, "LATCH": 0, "TRIGGER": 0, "LAMP": 0}


class Edge(NamedTuple):
    """A line took a level that it did not have."""
    t_ns: int
    line: str
    value: int


def changes(settings, levels):
    """Those of the settings, in order of time, that move their line from the levels it had."""
    levels, found = dict(levels), []
    for setting in settings:
        if levels.get(setting.line) != setting.value:
            found.append(setting)
        levels[setting.line] = setting.value
    return found
