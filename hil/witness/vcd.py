"""Edges to a Value Change Dump, in nanoseconds, for any logic-analyser viewer."""
FIRST_CODE = 33  # printable identifiers begin at '!'


def write(path, edges, lines):
    """Writes every edge; each line starts from the level that its first edge leaves."""
    codes = {line: chr(FIRST_CODE + i) for i, line in enumerate(lines)}
    shown = [edge for edge in edges if edge.line in codes]
    start_ns = shown[0].t_ns if shown else 0
    first = {}
    for edge in shown:
        first.setdefault(edge.line, 1 - edge.value)
    with open(path, "w", encoding="ascii") as out:
        out.write("$timescale 1 ns $end\n$scope module rig $end\n")
        for line, code in codes.items():
            out.write(f"$var wire 1 {code} {line} $end\n")
        out.write("$upscope $end\n$enddefinitions $end\n#0\n")
        for line, code in codes.items():
            out.write(f"{first.get(line, 0)}{code}\n")
        # One nanosecond on, so that an edge is seen even where it is the first thing that happens.
        for edge in shown:
            out.write(f"#{edge.t_ns - start_ns + 1}\n{edge.value}{codes[edge.line]}\n")
