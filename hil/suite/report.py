"""The page that a run leaves: every scene, what was measured, and what nothing looked at."""
import json
from typing import NamedTuple, Optional


class Measure(NamedTuple):
    """One number with its unit and, where it is judged, the limit that it may not exceed."""
    what: str
    value: float
    unit: str
    limit: Optional[float] = None

    def is_within(self):
        """A number without a limit is told, not judged."""
        return self.limit is None or self.value <= self.limit

    def __str__(self):
        number = f"{self.value:g}" if isinstance(self.value, int) else f"{self.value:.2f}"
        text = f"{self.what}: {number} {self.unit}".rstrip()
        return text if self.limit is None else f"{text} (at most {self.limit:g})"


class Result(NamedTuple):
    """faults are empty where the scene holds; skipped says why a target cannot play it."""
    scene: str
    measures: list
    faults: list
    notes: list = []
    skipped: str = ""

    def verdict(self):
        """pass, FAIL or the word for a scene that this target does not have."""
        if self.skipped:
            return "not here"
        return "FAIL" if self.faults or not all(m.is_within() for m in self.measures) else "pass"


def expect(faults, holds, otherwise):
    """Adds a fault in words where something does not hold."""
    if not holds:
        faults.append(otherwise)


def has_passed(results):
    """True only where something was played and nothing failed."""
    verdicts = [result.verdict() for result in results]
    return "FAIL" not in verdicts and "pass" in verdicts


def as_text(target, results, uncovered, facts):
    """For people."""
    lines = [f"Lamella, hardware in the loop: target {target}", ""]
    lines += [f"  {name}: {value}" for name, value in facts.items()] + [""]
    for result in results:
        lines.append(f"{result.verdict():8}  {result.scene}")
        lines += [f"            {measure}{'' if measure.is_within() else '  <- beyond'}"
                  for measure in result.measures]
        lines += [f"            {note}" for note in result.notes]
        lines += [f"            FAULT: {fault}" for fault in result.faults]
        lines += [f"            {result.skipped}"] if result.skipped else []
    lines += ["", "Not covered by this run:"] + [f"  - {line}" for line in uncovered]
    counts = {v: sum(r.verdict() == v for r in results) for v in ("pass", "FAIL", "not here")}
    lines += ["", ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
              + f": {'PASSED' if has_passed(results) else 'FAILED'}", ""]
    return "\n".join(lines)


def as_json(target, results, uncovered, facts):
    """For programs."""
    return json.dumps({
        "target": target, "passed": has_passed(results), "facts": facts,
        "scenes": [{"scene": r.scene, "verdict": r.verdict(),
                    "measures": [m._asdict() for m in r.measures],
                    "faults": r.faults, "notes": r.notes, "skipped": r.skipped} for r in results],
        "not_covered": uncovered}, indent=2) + "\n"
