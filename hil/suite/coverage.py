"""Which lines of the firmware's door to the kernel ran in the virtual machine (gcov)."""
import json
import shutil
import subprocess

from suite.report import Measure, Result

GCOV = "aarch64-linux-gnu-gcov"
# A static program loads no plug-in: its file has nothing to run here.
NOT_IN_THE_MACHINE = ("hal_linux_plugin.c",)


def count(gcov_reports):
    """{file: (lines that ran, lines of code)} of hal_linux's sources in gcov's reports."""
    found = {}
    for report in gcov_reports:
        for source in report["files"]:
            name = source["file"].rsplit("/", 1)[-1]
            if name.startswith("hal_linux") and name.endswith(".c"):
                counts = {line["line_number"]: line["count"] for line in source["lines"]}
                found[name] = (sum(n > 0 for n in counts.values()), len(counts))
    return found


def read(objects, counted, folder):
    """What a boot counted, beside the notes that the compiler left with its objects."""
    folder.mkdir(parents=True, exist_ok=True)
    reports = []
    for data in sorted(counted.rglob("hal_linux*.gcda")):
        shutil.copy(data, folder)
        shutil.copy(objects / data.with_suffix(".gcno").name, folder)
        told = subprocess.run([GCOV, "--json-format", "--stdout", data.name], cwd=folder, check=True,
                              stdout=subprocess.PIPE).stdout
        reports.append(json.loads(told))
    return count(reports)


def lines_run(ran, sources):
    """Reported, not judged: but a file of which nothing ran was not tried on a kernel at all."""
    faults = [f"nothing of {name} ran" for name in sources
              if name not in NOT_IN_THE_MACHINE and ran.get(name, (0, 0))[0] == 0]
    measures = [Measure(f"{name}: of {ran[name][1]} lines ran", 100 * ran[name][0] / ran[name][1], "%")
                for name in sources if name in ran and ran[name][1] > 0]
    total = [sum(lines) for lines in zip(*ran.values())] or [0, 0]
    if total[1]:
        measures.append(Measure(f"together: of {total[1]} lines ran", 100 * total[0] / total[1], "%"))
    return Result("lines of hal_linux that a burst on a kernel runs", measures, faults,
                  [f"not in a static program: {', '.join(NOT_IN_THE_MACHINE)}"])
